"""A language model's answer, which nobody vouches for: repaired where it is plain what was meant,
else refused with a reason."""

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from difflib import SequenceMatcher
from fractions import Fraction
from typing import Any

from mimeline.directions.gestures import WAYS
from mimeline.directions.times import MOST_SECONDS
from mimeline.timeline.checks import judge
from mimeline.timeline.clock import nearest_frame
from mimeline.timeline.draft import Draft, DraftInterval, nearest, shown
from mimeline.timeline.timeline import SIDES, Timeline
from mimeline.vocabulary import ACTIONS, NEUTRAL, TRACKS

MOST_INTERVALS = 500
MOST_OBJECTS = 50  # that are tried: what precedes an answer may hold braces too
LONGEST_NAME = 40  # characters
SPELT_ALIKE = 0.85  # how much two names share, of 1
NUMBER = re.compile(
    r"\s*(\d{1,6}(?:\.\d{1,9})?)\s*(?:s|sec|secs|second|seconds)?\s*", re.IGNORECASE
)


class Refused(Exception):
    """Why an answer is no timeline."""


@dataclass(frozen=True)
class Answer:
    """timeline: every track told. repairs: what was mended, a line each."""

    timeline: Timeline
    repairs: tuple[str, ...]


def read(text: str, fps: Fraction, n_frames: int | None, clip_id: str = "text") -> Answer:
    """The timeline of an answer: {"seconds": 4, "actions": [{"action": "Smile", "start_s": 1,
    "end_s": 2, "side": "left"}]}.

    n_frames: how long the clip is to be; None: as the answer says. Mended, and told: text around
    the JSON, names in other spelling, numbers in quotes, what reaches beyond the clip, what
    overlaps on a track (the later one cuts the earlier one short). Raises Refused for no JSON, an
    action that nobody knows, times that are none, or no action at all.
    """
    repairs: list[str] = []
    told = _object(text, repairs)
    entries = told.get("actions", told.get("timeline"))
    if not isinstance(entries, list):
        raise Refused('no list "actions"')
    if len(entries) > MOST_INTERVALS:
        raise Refused(f"{len(entries)} actions where {MOST_INTERVALS} are many")
    spans = [
        span for place, entry in enumerate(entries, 1) for span in _span(place, entry, repairs)
    ]
    if not spans:
        raise Refused("no action")
    if n_frames is None:
        seconds = _seconds(told.get("seconds"), repairs)
        if not seconds:
            seconds = max(span.end for span in spans) + 1
            if "seconds" in told:
                repairs.append(f"a length of {shown(told['seconds'])} left out")
        if seconds > MOST_SECONDS:
            raise Refused(f"a length of {float(seconds):g} s where {MOST_SECONDS} are many")
        n_frames = max(1, nearest_frame(seconds, fps))
    drafts = [_framed(span, fps, n_frames, repairs) for span in spans]
    drafts = [*_apart([draft for draft in drafts if draft is not None], repairs)]
    draft = Draft(
        clip_id, tuple(drafts), in_seconds=False, fps=fps, n_frames=n_frames, tracks=TRACKS
    )
    judged = judge(draft, clip_id)
    if judged.timeline is None:
        raise Refused(str(judged.problems[0]))
    if not any(judged.timeline.tracks.values()):
        raise Refused("no action within the clip")
    return Answer(judged.timeline, tuple(repairs))


@dataclass(frozen=True)
class _Span:
    place: str
    action: str
    start: Fraction
    end: Fraction
    side: str | None


def _object(text: str, repairs: list[str]) -> dict[str, Any]:
    """The first JSON object of a text that lists actions, else the first."""
    decoder = json.JSONDecoder(parse_constant=_no_number)
    found, fault, start = None, None, -1
    for _ in range(MOST_OBJECTS):
        if (start := text.find("{", start + 1)) < 0:
            break
        try:
            value, end = decoder.raw_decode(text, start)
        except (ValueError, RecursionError) as error:
            fault = fault or error
            continue
        if found is None or _lists_actions(value):
            found = value, start, end
        if _lists_actions(value):
            break
        start = end - 1
    if found is None:
        if fault:
            raise Refused(f"JSON that breaks off or is none ({fault})") from fault
        raise Refused(f"no JSON object in {shown(text)}")
    value, start, end = found
    if text[:start].strip() or text[end:].strip():
        repairs.append("text around the JSON left out")
    return value


def _lists_actions(value: dict[str, Any]) -> bool:
    return isinstance(value.get("actions", value.get("timeline")), list)


def _no_number(name: str) -> None:
    raise ValueError(f"{name}, which is no number")


def _span(place: int, entry: object, repairs: list[str]) -> Iterator[_Span]:
    if not isinstance(entry, dict):
        raise Refused(f"action {place}: {shown(entry)}, which is no object")
    name, said = entry.get("action"), f"action {place}"
    if not isinstance(name, str):
        raise Refused(f"{said}: no name")
    if name.strip().casefold() == NEUTRAL.casefold():
        repairs.append(f"{said}: Neutral left out; it is what is not asked for")
        return
    action = name if name in ACTIONS else _spelt_otherwise(name)
    if action is None:
        raise Refused(f"{said}: {shown(name)}, which is none of {', '.join(ACTIONS)}")
    if action != name:
        repairs.append(f"{said}: {shown(name)} taken for {action}")
    times = [_seconds(entry.get(key), repairs) for key in ("start_s", "end_s")]
    if None in times:
        raise Refused(f"{said}: start_s and end_s are not both seconds")
    side = _side(entry.get("side"), said)
    if side and ACTIONS[action].control_region in ("gaze", "head"):
        repairs.append(f"{said}: side {side} left out; {action} has none")
        side = None
    if times[0] >= times[1]:
        raise Refused(f"{said}: it ends before it starts")
    yield _Span(f"{said} ({action})", action, *times, side)


def _spelt_otherwise(name: str) -> str | None:
    """The action that a name is but for its spelling: "eyes closed" is EyeClose, "no smile" and
    "gaze up left" are none."""
    folded = re.sub(r"[\s_-]", "", name[:LONGEST_NAME]).casefold()
    action = nearest(folded, ACTIONS)
    if action is None:
        return None
    known = action.casefold()
    alike = SequenceMatcher(None, folded, known).ratio() >= SPELT_ALIKE
    same_ways = all((way in folded) == (way in known) for way in WAYS)
    return action if alike and same_ways else None


def _side(value: object, said: str) -> str | None:
    side = value.strip().casefold() if isinstance(value, str) else value
    if side in (None, "both", "", "none", "null"):
        return None
    if side not in SIDES:
        raise Refused(f"{said}: side {shown(value)}, neither left nor right nor null")
    return side


def _seconds(value: object, repairs: list[str]) -> Fraction | None:
    if isinstance(value, str) and (match := NUMBER.fullmatch(value)):
        repairs.append(f"{shown(value)} taken for a number")
        return Fraction(match[1])
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    return Fraction(str(value)) if 0 <= value <= 10**6 else None  # NaN is neither


def _framed(span: _Span, fps: Fraction, n_frames: int, repairs: list[str]) -> DraftInterval | None:
    start, end = (nearest_frame(second, fps) for second in (span.start, span.end))
    if start >= n_frames:
        repairs.append(f"{span.place} left out: it begins after the clip's end")
        return None
    if end > n_frames:
        repairs.append(f"{span.place} cut at the clip's end")
    end = min(max(end, start + 1), n_frames)
    return DraftInterval(span.place, None, span.action, start, end, span.side)


def _apart(drafts: list[DraftInterval], repairs: list[str]) -> Iterator[DraftInterval]:
    """Each interval ends where the next on its track and side begins."""
    for draft in drafts:
        track = ACTIONS[draft.action].track
        later = [
            other.start
            for other in drafts
            if other is not draft
            and ACTIONS[other.action].track == track
            and (other.side is None or draft.side is None or other.side == draft.side)
            and draft.start < other.start < draft.end
        ]
        if later:
            repairs.append(f"{draft.place} ends where the next on its track begins")
            draft = replace(draft, end=min(later))
        yield draft
