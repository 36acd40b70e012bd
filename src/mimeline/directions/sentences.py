"""Simple sentences as a timeline: "smile from 1 s to 2 s, then look left".

What is said is cut into gestures that follow each other (then, a comma, a full stop) and those that
go together (and, while). Every word is a part of a gesture, says when, or is one of a few that add
nothing: a sentence with any other word is refused, never guessed at.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction

from mimeline.directions.gestures import FILLERS, PLAIN, TIMING, UNSAYABLE, Gesture, matched
from mimeline.directions.times import MOST_SECONDS, When, taken
from mimeline.errors import MimelineError
from mimeline.timeline.checks import judge
from mimeline.timeline.clock import nearest_frame
from mimeline.timeline.draft import Draft, DraftInterval
from mimeline.timeline.timeline import Timeline
from mimeline.vocabulary import TRACKS

MOST_CHARACTERS, LONGEST_NUMBER = 2000, 12
WORD = re.compile(r"\d+(?:\.\d+)?|[^\W\d_]+(?:'[a-z]+)?|\S")
QUOTES = str.maketrans("’–—", "'--", '"“”„«»()[]*')  # and brackets, which say nothing
ENDS = {".", ";", "!", "?", ":"}
AFTER = ENDS | {"then", "afterwards", "next", "finally", "before"}
DURING = {"while", "as"}
MEANWHILE = {"meanwhile", "simultaneously"}
TOGETHER = DURING | MEANWHILE | {"and", "but", "&", "+"}
SAID_OTHERWISE = (
    ("after that", "then"),
    ("followed by", "then"),
    ("at the same time", "meanwhile"),
    ("as well", ""),
    ("an eyebrow", "one brow"),
    ("a brow", "one brow"),
    ("an eye", "one eye"),
)
NOTHING = When()
EXAMPLE = '"smile from 1 s to 2 s, then look left"'


class NotUnderstood(MimelineError):
    """A text says something that no action of the vocabulary is."""


@dataclass(frozen=True)
class Heard:
    """An action that was heard. words: what said so, in plain form. start, end: frames."""

    words: str
    action: str
    start: int
    end: int
    side: str | None


@dataclass
class _Part:
    """Gestures that go together over one time. participle: as in "smile, squinting"."""

    gestures: list[Gesture] = field(default_factory=list)
    when: When = NOTHING
    participle: bool = False

    def turns_from(self, last: "_Part") -> bool:
        """Whether it is the way back of what came last, as in "look left and right twice"."""
        one = self.gestures[0] if len(self.gestures) == 1 else None
        return one is not None and one.goes_on and one.excludes(last.gestures[-1])


@dataclass(frozen=True)
class _Step:
    """Actions of a gesture from start to end, seconds. open: nobody says when it ends."""

    gesture: Gesture
    actions: tuple[str, ...]
    start: Fraction
    end: Fraction
    open: bool


def read(
    text: str, fps: Fraction, n_frames: int | None = None, clip_id: str = "text"
) -> tuple[Timeline, list[Heard]]:
    """The timeline that a text asks for, every track told, and where each action comes from.

    n_frames: how long the clip is; None: until a second after the last action. Raises NotUnderstood
    for a text that is empty, too long, has a word that is not known, asks for what does not fit the
    clip, or for two actions at once that exclude each other.
    """
    groups = _groups(text, fps)
    length = None if n_frames is None else n_frames / fps
    if length is None:
        last = max(step.end for step in _laid(groups, None))
        open_end = any(part.when.until_end for group in groups for part in group)
        length = last if open_end else last + TIMING["after"]
    if length > MOST_SECONDS:
        raise _refused(f"a clip of {float(length):g} s", f"{MOST_SECONDS} s at most")
    n_frames = max(1, nearest_frame(length, fps)) if n_frames is None else n_frames
    heard = [
        Heard(step.gesture.words, action, *frames, step.gesture.side)
        for step in _laid(groups, length)
        for frames in [(nearest_frame(step.start, fps), nearest_frame(step.end, fps))]
        for action in step.actions
    ]
    drafts = tuple(
        DraftInterval(f'"{own.words}"', None, own.action, own.start, own.end, own.side)
        for own in heard
    )
    draft = Draft(clip_id, drafts, in_seconds=False, fps=fps, n_frames=n_frames, tracks=TRACKS)
    judged = judge(draft, clip_id)
    if judged.timeline is None:
        first = judged.problems[0]
        raise NotUnderstood(
            "the text",
            place=first.place,
            found=first.found,
            expected=first.expected,
            remedy="Say other times, or leave one of them out.",
        )
    return judged.timeline, heard


def _groups(text: str, fps: Fraction) -> list[list[_Part]]:
    """Gestures in their order: groups that follow each other, of parts that go together."""
    if len(text) > MOST_CHARACTERS:
        raise _refused(f"{len(text)} characters", f"{MOST_CHARACTERS} at most")
    words = WORD.findall(" ".join(text.lower().translate(QUOTES).split()))
    if not any(word[0].isalnum() for word in words):
        raise _refused("an empty text", "a sentence")
    longest = max((len(word) for word in words if word[0].isdigit()), default=0)
    if longest > LONGEST_NUMBER:
        raise _refused(f"a number of {longest} digits", f"{LONGEST_NUMBER} at most")
    told, times = taken(" ".join(words), fps)
    for said, meant in SAID_OTHERWISE:
        told = re.sub(rf"\b{said}\b", meant, told)
    groups: list[list[_Part]] = [[]]
    unknown: list[str] = []
    waiting = NOTHING  # said before what it is said of
    for mark, own in _clauses(told.split()):
        last = groups[-1][-1] if groups[-1] else None
        part, strange = _part(own, times, last.gestures[-1] if last else None)
        unknown += strange
        if not part.gestures:
            if last and mark != "after" and part.when.start is None:
                last.when = _joined(last.when, part.when)
            else:
                waiting = _joined(waiting, part.when)
        elif last and mark == "and" and part.turns_from(last) and last.when == NOTHING:
            last.gestures[-1] = last.gestures[-1].then(part.gestures[0])
            last.when = part.when
        else:
            part.when, waiting = _joined(part.when, waiting), NOTHING
            listed = mark == "," and not part.participle
            if last and (mark == "after" or listed or part.turns_from(last)):
                groups.append([])
            groups[-1].append(part)
    if unknown:
        raise _unknown(unknown)
    if not groups[0]:
        raise _refused(f'no action in "{text.strip()}"', "at least one")
    groups[-1][-1].when = _joined(groups[-1][-1].when, waiting)
    return groups


def _clauses(words: Sequence[str]) -> Iterator[tuple[str, list[str]]]:
    """Words between those that join them, each after how it follows: "after", "," or "and".

    What goes along with what comes after a comma ("while smiling, she looks left") is told by
    "and".
    """
    mark, own, during = "after", [], False
    for word in [*words, "."]:
        joint = _joint(word, bool(own) or mark != "after")
        if not joint:
            own.append(word)
            continue
        if own:
            yield mark, own
            along = mark == "after" and (during or own[0].endswith("ing"))
            mark, own, during = "and" if along and joint == "," else joint, [], False
        elif joint == "after" or word in MEANWHILE or (joint == "and" and mark == ","):
            mark = joint  # ", then" follows; ", and" goes together
        during = during or word in DURING


def _joint(word: str, goes_on: bool) -> str:
    """How what comes after a word follows what came before it; empty where it joins nothing.

    goes_on: something came before, in this sentence or this clause.
    """
    if word == "before" and not goes_on:
        return ""  # "before smiling, ..." is the other way round
    return "after" if word in AFTER else "and" if word in TOGETHER else word if word == "," else ""


def _part(
    words: Sequence[str], times: dict[str, When], before: Gesture | None
) -> tuple[_Part, list[str]]:
    """What a clause says, and its words that nobody knows. before: the gesture said last."""
    when = NOTHING
    for word in words:
        if word in times:
            when = _joined(when, times[word])
    own = [word for word in words if word not in times]
    plain = [PLAIN.get(word, word) for word in own]
    plain = [word for word in plain if word not in FILLERS and word != "-"]
    gestures, unknown = matched(plain, before)
    return _Part(gestures, when, bool(own) and own[0].endswith("ing")), unknown


def _joined(a: When, b: When) -> When:
    both = a.joined(b)
    if both is None or both.contradicts:
        raise _refused("two times for one action", "one")
    return both


def _laid(groups: Sequence[Sequence[_Part]], length: Fraction | None) -> list[_Step]:
    """Each gesture's steps. length: of the clip, None: not yet known.

    Parts that do not say when go with the first of their group that does. A step of which nobody
    says when it ends does so where the next on its track begins.
    """
    at, steps = TIMING["before"], []
    for group in groups:
        shared = next((w for part in group if (w := part.when.shared) != NOTHING), NOTHING)
        own = [
            step
            for part in group
            for gesture in part.gestures
            for step in _placed(gesture, _when(part, gesture, shared), at, length)
        ]
        at = max(step.end for step in own) + TIMING["pause"]
        steps += own
    return [replace(step, end=_cut(step, steps)) if step.open else step for step in steps]


def _when(part: _Part, gesture: Gesture, shared: When) -> When:
    """What is said of a gesture's time. One that has a length of its own, as a blink has, does not
    last as long as what goes with it."""
    brief = gesture.seconds is not None and part.when.shared == NOTHING
    return part.when.beside(replace(shared, lasts=None) if brief else shared)


def _cut(step: _Step, steps: Sequence[_Step]) -> Fraction:
    later = (
        other.start
        for other in steps
        if step.start < other.start < step.end and other.gesture.excludes(step.gesture)
    )
    return min(later, default=step.end)


def _placed(gesture: Gesture, when: When, at: Fraction, length: Fraction | None) -> Iterator[_Step]:
    """A gesture's steps in time; at: where it begins where nobody says."""
    times = when.times or gesture.times
    n_steps = len(gesture.steps) * times
    own = gesture.seconds or TIMING["gesture"]
    pause = TIMING["pause"] if len(gesture.steps) == 1 else Fraction(0)
    natural = n_steps * own + (times - 1) * pause
    lasts = when.lasts or when.manner or natural
    if when.last is not None:
        start = (length or at + when.last) - when.last
        end = start + when.last
    else:
        told_end = length if when.until_end else when.end
        start = when.start
        if start is None:
            timed = bool(when.lasts or when.manner or gesture.seconds)
            start = at if told_end is None else _begun(at, told_end, lasts, timed)
        end = start + lasts if told_end is None else told_end
    scale = (end - start) / natural
    open_end = when.open and gesture.seconds is None and n_steps == 1
    moment = start
    for _ in range(times):
        for actions in gesture.steps:
            yield _Step(gesture, actions, moment, moment + own * scale, open_end)
            moment += own * scale
        moment += pause * scale


def _begun(at: Fraction, end: Fraction, lasts: Fraction, timed: bool) -> Fraction:
    """When something begins of which only the end is said: in its turn, at; where its length is
    known, or it comes first and ends early, as long before the end as it lasts."""
    before = max(Fraction(0), end - lasts)
    return before if timed else min(at, before) if at == TIMING["before"] else at


def _unknown(words: Sequence[str]) -> NotUnderstood:
    listed = ", ".join(f'"{word}"' for word in dict.fromkeys(words))
    because = next((UNSAYABLE[word] for word in words if word in UNSAYABLE), None)
    return NotUnderstood(
        "the text",
        found=f"{listed}, which no simple sentence says{f' ({because})' if because else ''}",
        expected=f"actions of the face, as in {EXAMPLE}",
        remedy="Say it by the 16 actions (docs/generate.md has the words), or name a language "
        "model that reads any text: --endpoint.",
    )


def _refused(found: str, expected: str) -> NotUnderstood:
    return NotUnderstood(
        "the text", found=found, expected=expected, remedy=f"Say it as in {EXAMPLE}."
    )
