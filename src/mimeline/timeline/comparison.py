"""Where two timelines of a clip differ, and how far they agree."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Literal

import numpy as np

from mimeline.errors import BadFile
from mimeline.timeline.timeline import SIDES, Interval, Timeline
from mimeline.vocabulary import TRACKS, track_actions

IN_PLACE = 0.5  # intersection over union, from which two actions are at one place

Kind = Literal["only in a", "only in b", "moved", "another"]
Pair = tuple[Interval, Interval]


@dataclass(frozen=True)
class Change:
    """An interval of a and what is there in b; None where there is nothing."""

    a: Interval | None
    b: Interval | None

    @property
    def kind(self) -> Kind:
        """moved: the same action of the same side, on other frames; another: at its place."""
        if self.a is None:
            return "only in b"
        if self.b is None:
            return "only in a"
        return "moved" if alike(self.a, self.b) else "another"

    @property
    def track(self) -> str:
        """The track on which it is."""
        return (self.a or self.b).track

    @property
    def shift(self) -> tuple[int, int]:
        """Frames by which start and end are later in b; (0, 0) where one of them has nothing."""
        if self.a is None or self.b is None:
            return 0, 0
        return self.b.start - self.a.start, self.b.end - self.a.end


@dataclass(frozen=True)
class Agreement:
    """How far two timelines agree on a track, frame by frame.

    share: of the frames, one where there are none. kappa: beyond chance (Cohen 1960); None where
    chance alone makes them agree, as where both show one thing throughout.
    """

    share: float
    kappa: float | None


@dataclass(frozen=True)
class Difference:
    """How timeline b differs from a.

    changes: track by track, in time. agreement: of the tracks that both measure. only_a, only_b:
    tracks that one of them measures; their intervals are no changes.
    """

    a: Timeline
    b: Timeline
    changes: tuple[Change, ...]
    agreement: dict[str, Agreement]
    only_a: tuple[str, ...]
    only_b: tuple[str, ...]

    def __bool__(self) -> bool:
        """Whether there is any."""
        return bool(self.changes or self.only_a or self.only_b)


def diff(a: Timeline, b: Timeline) -> Difference:
    """How b differs from a: in actions, sides and frames, not in what they were found by.

    Of the intervals that are not the same in both, those of one action and side that share frames
    are a pair, the longest shared first; then those whose intersection over union is IN_PLACE or
    more. Names of clips may differ. Raises BadFile where frame rates or lengths do: then frames
    cannot be compared.
    """
    require_same_frames(a, b)
    both = [track for track in TRACKS if track in a.tracks and track in b.tracks]
    return Difference(
        a,
        b,
        tuple(change for track in both for change in _changes(a.tracks[track], b.tracks[track])),
        {track: _agreement(classes(a, track), classes(b, track)) for track in both},
        tuple(track for track in a.tracks if track not in b.tracks),
        tuple(track for track in b.tracks if track not in a.tracks),
    )


def require_same_frames(a: Timeline, b: Timeline) -> None:
    """Raises BadFile where the timelines differ in frame rate or in length."""
    for place, one, other, option in (
        ("frames per second", a.fps, b.fps, "--fps"),
        ("frames", a.n_frames, b.n_frames, "--frames"),
    ):
        if one != other:
            raise BadFile(
                a.clip_id,
                place=place,
                found=f"{one} in the first timeline and {other} in the second",
                expected="timelines of one clip",
                remedy=f"See that they are. What a file does not tell is told by {option}.",
            )


def classes(timeline: Timeline, track: str) -> np.ndarray:
    """(n_frames,) int: one number for each pair of what both halves of the face show; 0 neutral."""
    actions = track_actions(track)
    halves = np.zeros((len(SIDES), timeline.n_frames), dtype="int64")
    for interval in timeline.tracks[track]:
        rows = slice(None) if interval.side is None else SIDES.index(interval.side)
        halves[rows, interval.start : interval.end] = actions.index(interval.action) + 1
    return halves[0] * (len(actions) + 1) + halves[1]


def alike(x: Interval, y: Interval) -> bool:
    """Whether the two show the same action on the same side."""
    return (x.action, x.side) == (y.action, y.side)


def shared(x: Interval, y: Interval) -> int:
    """Frames that both intervals hold."""
    return max(0, min(x.end, y.end) - max(x.start, y.start))


def meeting(a: Iterable[Interval], b: Sequence[Interval]) -> Iterator[Pair]:
    """Pairs that share frames or touch. a, b: of one track, in the order of their starts."""
    first = 0
    for x in a:
        while first < len(b) and b[first].end < x.start:
            first += 1
        for y in islice(b, first, None):
            if y.start > x.end:
                break
            if y.end >= x.start:
                yield x, y


def _changes(a: Sequence[Interval], b: Sequence[Interval]) -> list[Change]:
    same = {_what(interval) for interval in a} & {_what(interval) for interval in b}
    a = [interval for interval in a if _what(interval) not in same]
    b = [interval for interval in b if _what(interval) not in same]
    moved = _paired(a, b, lambda x, y: shared(x, y) if alike(x, y) else 0)
    a, b = _without(a, moved), _without(b, moved)
    another = _paired(a, b, lambda x, y: iou if (iou := _iou(x, y)) >= IN_PLACE else 0)
    found = [Change(x, y) for x, y in (*moved, *another)]
    found += [Change(x, None) for x in _without(a, another)]
    found += [Change(None, y) for y in _without(b, another)]
    return sorted(found, key=lambda change: min(_what(i) for i in (change.a, change.b) if i))


def _paired(
    a: Sequence[Interval], b: Sequence[Interval], worth: Callable[[Interval, Interval], float]
) -> list[Pair]:
    """Pairs of which none shares an interval with another, the worthiest first; 0 is no pair."""
    found, taken = [], set()
    for x, y in sorted(meeting(a, b), key=lambda pair: -worth(*pair)):
        if worth(x, y) and x not in taken and y not in taken:
            found.append((x, y))
            taken |= {x, y}
    return found


def _without(intervals: Iterable[Interval], pairs: Iterable[Pair]) -> list[Interval]:
    taken = {interval for pair in pairs for interval in pair}
    return [interval for interval in intervals if interval not in taken]


def _iou(x: Interval, y: Interval) -> float:
    both = shared(x, y)
    return both / (x.end - x.start + y.end - y.start - both)


def _what(interval: Interval) -> tuple:
    return interval.start, interval.end, interval.side or "", interval.action


def _agreement(a: np.ndarray, b: np.ndarray) -> Agreement:
    """a, b: (n_frames,) of `classes`."""
    if not len(a):
        return Agreement(1.0, None)
    share, size = float((a == b).mean()), int(max(a.max(), b.max())) + 1
    chance = np.bincount(a, minlength=size) @ np.bincount(b, minlength=size) / len(a) ** 2
    return Agreement(share, None if chance == 1 else float((share - chance) / (1 - chance)))
