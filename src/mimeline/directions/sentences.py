"""Simple sentences as a timeline: "smile from 1 s to 2 s, then look left".

What is said is cut into gestures that follow each other (then, a comma, a full stop) and those that
go together (and, while). Every word is a part of a gesture, says when, or is one of a few that add
nothing: a sentence with any other word is refused, never guessed at.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction

from mimeline.directions.gestures import FILLERS, PLAIN, TIMING, Gesture, matched
from mimeline.directions.times import When, taken
from mimeline.errors import MimelineError
from mimeline.timeline.checks import judge
from mimeline.timeline.clock import nearest_frame
from mimeline.timeline.draft import Draft, DraftInterval
from mimeline.timeline.timeline import Timeline
from mimeline.vocabulary import TRACKS

MOST_CHARACTERS = 2000
WORD = re.compile(r"\d+(?:\.\d+)?|[^\W\d_]+(?:'[a-z]+)?|[.,;:!?-]")
AFTER = {".", ";", "!", "?", ":", "then", "afterwards", "next", "finally", "before"}
TOGETHER = {"and", "while", "as", "meanwhile", "simultaneously"}
SAID_OTHERWISE = (
    ("after that", "then"),
    ("followed by", "then"),
    ("at the same time", "meanwhile"),
    ("as well", ""),
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
    """Gestures that go together over one time. raw: the first word as it was said."""

    gestures: list[Gesture] = field(default_factory=list)
    when: When = NOTHING
    raw: str = ""


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
        laid = [*_laid(groups, None)]
        last = max(end for *_, end in laid)
        open_end = any(part.when.until_end for group in groups for part in group)
        length = last if open_end else last + TIMING["after"]
    n_frames = max(1, nearest_frame(length, fps)) if n_frames is None else n_frames
    heard = [
        Heard(
            gesture.words, action, nearest_frame(start, fps), nearest_frame(end, fps), gesture.side
        )
        for gesture, action, start, end in _laid(groups, length)
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
    words = WORD.findall(" ".join(text.lower().replace("’", "'").replace("–", "-").split()))
    if not any(word[0].isalnum() for word in words):
        raise _refused("an empty text", "a sentence")
    if len(text) > MOST_CHARACTERS:
        raise _refused(f"{len(text)} characters", f"{MOST_CHARACTERS} at most")
    told, times = taken(" ".join(words), fps)
    for said, meant in SAID_OTHERWISE:
        told = re.sub(rf"\b{said}\b", meant, told)
    groups: list[list[_Part]] = [[]]
    unknown: list[str] = []
    waiting = NOTHING
    for mark, own in _clauses(told.split()):
        part, strange = _part(own, times, _last_gesture(groups))
        unknown += strange
        if mark == "after" or (mark == "," and not part.raw.endswith("ing")):
            groups.append([])
        if part.gestures:
            part.when = _joined(part.when, waiting)
            waiting = NOTHING
            groups[-1].append(part)
        elif groups[-1]:
            groups[-1][-1].when = _joined(groups[-1][-1].when, part.when)
        else:
            waiting = _joined(waiting, part.when)
    groups = [group for group in groups if group]
    if unknown:
        raise _unknown(unknown)
    if not groups:
        raise _refused(f'no action in "{text.strip()}"', "at least one")
    return groups


def _clauses(words: Sequence[str]) -> Iterator[tuple[str, list[str]]]:
    """Words between those that join them, each after how it follows: "after", "," or "and"."""
    mark, own = "and", []
    for word in words:
        joint = (
            "after" if word in AFTER else "and" if word in TOGETHER else word if word == "," else ""
        )
        if not joint:
            own.append(word)
            continue
        if own:
            yield mark, own
            mark, own = joint, []
        elif (
            joint == "after" or mark == "and" or (joint == "and" and mark == ",")
        ):  # ", then" follows; ", and" goes together
            mark = joint
    if own:
        yield mark, own


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
    return _Part(gestures, when, own[0] if own else ""), unknown


def _last_gesture(groups: Sequence[Sequence[_Part]]) -> Gesture | None:
    parts = [part for group in groups for part in group]
    return parts[-1].gestures[-1] if parts else None


def _joined(a: When, b: When) -> When:
    both = a.joined(b)
    if both is None:
        raise _refused("two times for one action", "one")
    return both


def _laid(
    groups: Sequence[Sequence[_Part]], length: Fraction | None
) -> Iterator[tuple[Gesture, str, Fraction, Fraction]]:
    """Each gesture's actions with start and end, seconds. length: of the clip, None: not yet known.

    Parts that do not say when go with the first of their group that does.
    """
    at = TIMING["before"]
    for group in groups:
        told = next((part.when for part in group if part.when != NOTHING), NOTHING)
        ends = []
        for part in group:
            when = told if part.when == NOTHING else part.when
            if part.when.times and part.when == When(times=part.when.times):
                when = replace(told, times=part.when.times)
            for gesture in part.gestures:
                for action, start, end in _placed(gesture, when, at, length):
                    ends.append(end)
                    yield gesture, action, start, end
        at = max(ends) + TIMING["pause"]


def _placed(
    gesture: Gesture, when: When, at: Fraction, length: Fraction | None
) -> Iterator[tuple[str, Fraction, Fraction]]:
    """A gesture's actions in time; at: where it begins where nobody says."""
    times = when.times or gesture.times
    n_steps = len(gesture.steps) * times
    own = gesture.seconds or TIMING["gesture"]
    pause = TIMING["pause"] if len(gesture.steps) == 1 else Fraction(0)
    natural = n_steps * own + (times - 1) * pause
    lasts = when.lasts or natural
    if when.last is not None:
        start = (length or at + when.last) - when.last
        end = start + when.last
    elif when.until_end:
        start = when.start
        if start is None:
            start = at if length is None else length - lasts
        end = start + lasts if length is None else length
    else:
        start = when.start
        if start is None:
            start = at if when.end is None else max(Fraction(0), when.end - lasts)
        end = start + lasts if when.end is None else when.end
    scale = (end - start) / natural if natural else Fraction(1)
    moment = start
    for _ in range(times):
        for step in gesture.steps:
            for action in step:
                yield action, moment, moment + own * scale
            moment += own * scale
        moment += pause * scale


def _unknown(words: Sequence[str]) -> NotUnderstood:
    listed = ", ".join(f'"{word}"' for word in dict.fromkeys(words))
    return NotUnderstood(
        "the text",
        found=f"{listed}, which no simple sentence says",
        expected=f"actions of the face, as in {EXAMPLE}",
        remedy="Say it by the 16 actions (docs/generate.md has the words), or name a language "
        "model that reads any text: --endpoint.",
    )


def _refused(found: str, expected: str) -> NotUnderstood:
    return NotUnderstood(
        "the text", found=found, expected=expected, remedy=f"Say it as in {EXAMPLE}."
    )
