"""JSON of our own schema (`resources/timeline.schema.json`): keeps all that a Timeline holds."""

import json
from collections import Counter
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

from mimeline.errors import BadFile
from mimeline.timeline.clock import MOST_FRAMES
from mimeline.timeline.draft import Draft, DraftInterval, Problem, nearest, shown
from mimeline.timeline.formats.json_schema import VERSION
from mimeline.timeline.formats.text_file import read_text
from mimeline.timeline.timeline import SIDES, SOURCES, Interval, Timeline

MOST_BYTES = 512 * 2**20  # the timelines of a whole data set
CLIP_KEYS = ("schema_version", "clip_id", "fps", "n_frames", "tracks")
INTERVAL_KEYS = ("action", "start_frame", "end_frame", "side", "source", "cluster", "confidence")
MOST_OF_RATE = 10**6


def read(path: Path) -> list[Draft]:
    """A draft per clip of the file."""
    text = read_text(path, "timelines in JSON", MOST_BYTES)
    try:
        content = json.loads(text, object_pairs_hook=_once, parse_constant=_refuse)
    except json.JSONDecodeError as error:
        raise BadFile(
            path,
            place=f"line {error.lineno}, column {error.colno}",
            found=error.msg,
            expected="JSON",
            remedy="Mend the text there.",
        ) from error
    except (ValueError, RecursionError) as error:
        raise BadFile(
            path,
            found=str(error),
            expected="JSON as its schema has it",
            remedy="Mend the file by resources/timeline.schema.json.",
        ) from error
    if isinstance(content, list):
        return [_Reader(f"clip {n}, ").draft(clip) for n, clip in enumerate(content, start=1)]
    return [draft(content)]


def draft(clip: object) -> Draft:
    """The draft of one clip as JSON has it."""
    return _Reader("").draft(clip)


def _once(pairs: list[tuple[str, object]]) -> dict[str, object]:
    found = dict(pairs)
    if len(found) < len(pairs):
        counts = Counter(name for name, _ in pairs)
        doubled = next(name for name, count in counts.items() if count > 1)
        raise ValueError(f"key {shown(doubled)} twice in one object")
    return found


def _refuse(name: str) -> None:
    raise ValueError(f"{name}, which is no JSON number")


class _Reader:
    """Reads one clip and collects what is wrong in it. prefix: of every place."""

    def __init__(self, prefix: str):
        self.prefix = prefix
        self.problems: list[Problem] = []

    def draft(self, clip: object) -> Draft:
        intervals: list[DraftInterval] = []
        told = self._object("", clip, CLIP_KEYS)
        if told is None:
            return Draft(None, (), in_seconds=False, problems=tuple(self.problems))
        if _whole(told.get("schema_version")) != VERSION:
            self._wrong("schema_version", told.get("schema_version"), str(VERSION))
        clip_id = told.get("clip_id")
        if not (isinstance(clip_id, str) and clip_id):
            self._wrong("clip_id", clip_id, "the clip's name")
        tracks = told.get("tracks")
        if not isinstance(tracks, dict):
            self._wrong("tracks", tracks, "an object with a list per measured track")
            tracks = {}
        for track, entries in tracks.items():
            place = f"tracks.{track}"
            if not isinstance(entries, list):
                self._wrong(place, entries, "a list of intervals")
                continue
            for number, entry in enumerate(entries):
                intervals += self._interval(f"{place}[{number}]", track, entry)
        return Draft(
            clip_id if isinstance(clip_id, str) else None,
            tuple(intervals),
            in_seconds=False,
            fps=self._rate(told["fps"]) if "fps" in told else None,
            n_frames=self._count("n_frames", told["n_frames"]) if "n_frames" in told else None,
            tracks=tuple(tracks),
            problems=tuple(self.problems),
        )

    def _interval(self, place: str, track: str, entry: object) -> list[DraftInterval]:
        before = len(self.problems)
        told = self._object(place, entry, INTERVAL_KEYS)
        if told is None:
            return []
        action = told.get("action")
        if not isinstance(action, str):
            self._wrong(f"{place}.action", action, "an action's name")
        start, end = (
            self._count(f"{place}.{name}", told.get(name)) for name in ("start_frame", "end_frame")
        )
        side, source = told.get("side"), told.get("source", "human")
        if side not in (None, *SIDES):
            self._wrong(f"{place}.side", side, f"{' or '.join(SIDES)}, or no such key")
        if source not in SOURCES:
            self._wrong(f"{place}.source", source, f"one of {', '.join(SOURCES)}")
        cluster, confidence = told.get("cluster"), told.get("confidence")
        if cluster is not None:
            cluster = self._count(f"{place}.cluster", cluster)
        if confidence is not None and not _is_share(confidence):
            self._wrong(f"{place}.confidence", confidence, "a share of 0 to 1")
        if len(self.problems) > before:
            return []
        return [
            DraftInterval(
                self.prefix + place,
                track,
                action,
                start,
                end,
                side=side,
                source=source,
                cluster=cluster,
                confidence=None if confidence is None else float(confidence),
            )
        ]

    def _object(self, place: str, value: object, keys: Sequence[str]) -> dict | None:
        if not isinstance(value, dict):
            self._wrong(place or "the clip", value, f"an object with {', '.join(keys)}")
            return None
        for name in value:
            if name not in keys:
                close = nearest(name, keys)
                self._wrong(
                    place or "the clip",
                    name,
                    f"keys of {', '.join(keys)}",
                    f"Did you mean {close}?" if close else "Take it out.",
                )
        return value

    def _count(self, place: str, value: object) -> int | None:
        count = _whole(value)
        if count is not None and 0 <= count <= MOST_FRAMES:
            return count
        self._wrong(place, value, "a whole number, 0 or more")
        return None

    def _rate(self, value: object) -> Fraction | None:
        told = self._object("fps", value, ("num", "den"))
        if told is None:
            return None
        above, below = (_whole(told.get(name)) or 0 for name in ("num", "den"))
        if 0 < above <= MOST_OF_RATE and 0 < below <= MOST_OF_RATE:
            return Fraction(above, below)
        self._wrong("fps", value, 'a fraction like {"num": 30000, "den": 1001}')
        return None

    def _wrong(self, place: str, value: object, expected: str, remedy: str = "Mend it.") -> None:
        found = "nothing" if value is None else shown(value)
        self.problems.append(Problem(self.prefix + place, found, expected, remedy))


def _whole(value: object) -> int | None:
    """A whole number; JSON knows one kind of number, so 3.0 is one."""
    if type(value) is float and value.is_integer():
        return int(value)
    return value if type(value) is int else None


def _is_share(value: object) -> bool:
    return type(value) in (int, float) and 0 <= value <= 1


def write(timelines: Sequence[Timeline]) -> str:
    """The timelines as text, an interval per line so that changes are read line by line."""
    if len(timelines) == 1:
        return f"{_clip(timelines[0])}\n"
    clips = ",\n".join(_clip(timeline) for timeline in timelines)
    return f"[\n{clips}\n]\n" if clips else "[]\n"


def _clip(timeline: Timeline) -> str:
    tracks = ",\n".join(f'    "{t}": {_track(found)}' for t, found in timeline.tracks.items())
    fps = {"num": timeline.fps.numerator, "den": timeline.fps.denominator}
    lines = (
        f'  "schema_version": {VERSION}',
        f'  "clip_id": {json.dumps(timeline.clip_id)}',
        f'  "fps": {json.dumps(fps)}',
        f'  "n_frames": {timeline.n_frames}',
        f'  "tracks": {{\n{tracks}\n  }}' if tracks else '  "tracks": {}',
    )
    return "{\n" + ",\n".join(lines) + "\n}"


def _track(intervals: Sequence[Interval]) -> str:
    rows = ",\n".join(f"      {json.dumps(_told(interval))}" for interval in intervals)
    return f"[\n{rows}\n    ]" if rows else "[]"


def _told(interval: Interval) -> dict:
    told = {
        "action": interval.action,
        "start_frame": interval.start,
        "end_frame": interval.end,
        "side": interval.side,
        "source": interval.source,
        "cluster": interval.cluster,
        "confidence": interval.confidence,
    }
    return {name: value for name, value in told.items() if value is not None}
