"""Two timelines of a clip made one: tracks of both, and who is right where they conflict."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from mimeline.errors import BadFile
from mimeline.timeline.comparison import Pair, alike, meeting, require_same_frames, shared
from mimeline.timeline.timeline import Interval, Timeline
from mimeline.vocabulary import TRACKS

TOLD = 3  # conflicts that an error names

Preferred = Literal["first", "second"]


def merge(a: Timeline, b: Timeline, prefer: Preferred | None = None) -> Timeline:
    """One timeline with the tracks of both.

    An interval of a that overlaps or touches one of b of the same action and side is joined with
    it. Others that exclude each other conflict: the preferred timeline's stands, the other one
    loses these frames, and where they are more than half of it, it goes.

    Raises BadFile where clip, frame rate or length are not the same, and for conflicts where
    neither is preferred.
    """
    _require_one_clip(a, b)
    tracks, met = {}, []
    for track in (track for track in TRACKS if track in {*a.tracks, *b.tracks}):
        first, second = a.tracks.get(track, ()), b.tracks.get(track, ())
        if prefer == "first":
            second = _giving_way(second, first)
        elif prefer == "second":
            first = _giving_way(first, second)
        met += conflicts(first, second)
        tracks[track] = first, second
    if met:
        raise _conflict(a, met)
    joined = {track: _joined(first, second) for track, (first, second) in tracks.items()}
    return Timeline(a.clip_id, a.fps, a.n_frames, joined)


@dataclass(frozen=True)
class Cost:
    """What became of the intervals of two timelines in the one that was made of them.

    joined: intervals that are longer there than in one of the two. cut: those that lost frames.
    left_out: those that went.
    """

    joined: int
    cut: int
    left_out: int


def cost(a: Timeline, b: Timeline, merged: Timeline) -> Cost:
    """How many intervals were joined, cut and left out. merged: what `merge` made of a and b."""
    longer, cut, left_out = set(), 0, 0
    for timeline in (a, b):
        for track, intervals in timeline.tracks.items():
            there: dict[Interval, list[Interval]] = {interval: [] for interval in intervals}
            for interval, made in meeting(intervals, merged.tracks[track]):
                if alike(interval, made) and shared(interval, made):
                    there[interval].append(made)
            for interval, pieces in there.items():
                length = interval.end - interval.start
                if sum(shared(interval, piece) for piece in pieces) == length:
                    longer |= {piece for piece in pieces if _place(piece) != _place(interval)}
                elif pieces:
                    cut += 1
                else:
                    left_out += 1
    return Cost(len(longer), cut, left_out)


def conflicts(a: Sequence[Interval], b: Sequence[Interval]) -> list[Pair]:
    """Pairs that exclude each other and do not show the same. a, b: of one track, in time."""
    return [(x, y) for x, y in meeting(a, b) if x.excludes(y) and not alike(x, y)]


def _giving_way(intervals: Sequence[Interval], preferred: Sequence[Interval]) -> list[Interval]:
    """What is left of intervals beside those that are preferred."""
    others: dict[Interval, list[Interval]] = {}
    for interval, other in conflicts(intervals, preferred):
        others.setdefault(interval, []).append(other)
    kept = []
    for interval in intervals:
        pieces = _pieces(interval, others.get(interval, ()))
        left = sum(piece.end - piece.start for piece in pieces)
        if 2 * left >= interval.end - interval.start:
            kept += pieces
    return sorted(kept, key=lambda piece: piece.start)


def _pieces(interval: Interval, others: Collection[Interval]) -> list[Interval]:
    """The interval without the frames of others, which are sorted by their starts."""
    found, start = [], interval.start
    for other in others:
        if start < other.start:
            found.append(replace(interval, start=start, end=other.start))
        start = max(start, other.end)
    if start < interval.end:
        found.append(replace(interval, start=start))
    return found


def _joined(first: Sequence[Interval], second: Sequence[Interval]) -> list[Interval]:
    """The intervals of both; what continues an interval of the other timeline is one with it.

    Two that touch stay two where one of them is in both timelines, which end it there.
    """
    group = {interval: {interval} for interval in (*first, *second)}
    ended = {_place(interval) for interval in first} & {_place(interval) for interval in second}
    for x, y in meeting(first, second):
        if alike(x, y) and (shared(x, y) or ended.isdisjoint((_place(x), _place(y)))):
            both = group[x] | group[y]
            group |= dict.fromkeys(both, both)
    return [_one(parts) for parts in {frozenset(parts) for parts in group.values()}]


def _place(interval: Interval) -> tuple:
    return interval.action, interval.side, interval.start, interval.end


def _one(parts: Collection[Interval]) -> Interval:
    """The parts as one interval; of where they come from, what they do not agree on is left out."""
    sources, clusters, shares = (
        {getattr(part, name) for part in parts} for name in ("source", "cluster", "confidence")
    )
    return replace(
        min(parts, key=lambda part: part.start),
        end=max(part.end for part in parts),
        source=sources.pop() if len(sources) == 1 else "human",
        cluster=clusters.pop() if len(clusters) == 1 else None,
        confidence=shares.pop() if len(shares) == 1 else None,
    )


def _require_one_clip(a: Timeline, b: Timeline) -> None:
    require_same_frames(a, b)
    if a.clip_id != b.clip_id:
        raise BadFile(
            a.clip_id,
            place="clip",
            found=f"{a.clip_id} in the first timeline and {b.clip_id} in the second",
            expected="timelines of one clip",
            remedy="See that they are. What a file does not tell is told by --clip.",
        )


def _conflict(a: Timeline, met: Sequence[Pair]) -> BadFile:
    told = "; ".join(_told(a, *pair) for pair in met[:TOLD])
    more = f"; and {len(met) - TOLD} more" if len(met) > TOLD else ""
    return BadFile(
        a.clip_id,
        found=f"{told}{more}",
        expected="one action at a time on a track",
        remedy="Decide with --prefer first or --prefer second, or mend one of the files.",
    )


def _told(a: Timeline, x: Interval, y: Interval) -> str:
    start, end = max(x.start, y.start), min(x.end, y.end)
    seconds = f"{float(start / a.fps):.2f} to {float(end / a.fps):.2f} s"
    one, other = (f"{i.action} {i.side or ''}".rstrip() for i in (x, y))
    return f"{one} against {other} on {x.track} in frames {start} to {end} ({seconds})"
