"""The Timeline: which facial action a clip shows on which track, from frame to frame."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

from mimeline.vocabulary import ACTIONS, TRACKS

Side = Literal["left", "right"]
Source = Literal["ticc", "threshold", "human"]

SIDES: tuple[Side, ...] = ("left", "right")
SOURCES: tuple[Source, ...] = ("ticc", "threshold", "human")


@dataclass(frozen=True)
class Interval:
    """An action that holds over the half-open frames [start, end).

    side: the subject's; None: both, or an action that has no side. cluster: which one of TICC's
    named it. confidence: a share.
    """

    action: str
    start: int
    end: int
    side: Side | None = None
    source: Source = "human"
    cluster: int | None = None
    confidence: float | None = None

    @property
    def track(self) -> str:
        """The track that holds the action."""
        return ACTIONS[self.action].track

    def excludes(self, other: "Interval") -> bool:
        """Whether the two cannot both be: they share a frame, a track and a side of the face."""
        return (
            self.track == other.track
            and sides_meet(self.side, other.side)
            and self.start < other.end
            and other.start < self.end
        )


@dataclass(frozen=True)
class Timeline:
    """The actions of one clip.

    fps: frames per second; frame i covers [i / fps, (i + 1) / fps).
    tracks: a key per measured track (an empty one is neutral throughout); held in the order of
    TRACKS, each track's intervals sorted.

    Raises ValueError where the clip has no name, or an interval is empty, out of the clip, on a
    track that is not its action's, shares a frame with another one of its track and side, or has a
    side, source, cluster or confidence that there is not.
    """

    clip_id: str
    fps: Fraction
    n_frames: int
    tracks: Mapping[str, Sequence[Interval]]

    def __post_init__(self):
        unknown = [track for track in self.tracks if track not in TRACKS]
        if unknown:
            raise ValueError(f"{self.clip_id}: no track is called {', '.join(map(repr, unknown))}")
        if not self.clip_id:
            raise ValueError("a timeline belongs to a clip, which has a name")
        if self.fps <= 0 or self.n_frames < 0:
            raise ValueError(f"{self.clip_id}: {self.n_frames} frames at {self.fps} per second")
        tracks = {t: tuple(sorted(self.tracks[t], key=_order)) for t in TRACKS if t in self.tracks}
        for track, intervals in tracks.items():
            self._check(track, intervals)
        object.__setattr__(self, "fps", Fraction(self.fps))
        object.__setattr__(self, "tracks", tracks)

    def _check(self, track: str, intervals: tuple[Interval, ...]) -> None:
        for interval in intervals:
            if interval.action not in ACTIONS or interval.track != track:
                raise ValueError(f"{self.clip_id}: {interval.action} is no action of {track}")
            if interval.side not in (None, *SIDES) or interval.source not in SOURCES:
                raise ValueError(f"{self.clip_id}: {interval} has no such side or source")
            if interval.confidence is not None and not 0 <= interval.confidence <= 1:
                raise ValueError(f"{self.clip_id}: the confidence of {interval} is no share")
            if interval.cluster is not None and interval.cluster < 0:
                raise ValueError(f"{self.clip_id}: the cluster of {interval} is below 0")
            if not 0 <= interval.start < interval.end <= self.n_frames:
                raise ValueError(f"{self.clip_id}: {interval} in a clip of {self.n_frames} frames")
        for a, b in overlaps(intervals):
            raise ValueError(f"{self.clip_id}: on {track}, {a} shares frames with {b}")

    def __iter__(self) -> Iterator[Interval]:
        """Every interval, track by track, each track in time."""
        return (interval for intervals in self.tracks.values() for interval in intervals)

    @property
    def seconds(self) -> float:
        """How long the clip lasts."""
        return float(self.n_frames / self.fps)


def sides_meet(a: str | None, b: str | None) -> bool:
    """Whether two sides share a half of the face: None is both halves."""
    return a is None or b is None or a == b


def overlaps(intervals: Sequence[Interval]) -> Iterator[tuple[Interval, Interval]]:
    """Pairs that exclude each other, of one track's intervals in the order of their starts.

    Each interval is compared with the one of its side that reaches furthest before it.
    """
    furthest: dict[str, Interval] = {}  # by half of the face
    for interval in intervals:
        halves = SIDES if interval.side is None else (interval.side,)
        before = [furthest[half] for half in halves if half in furthest]
        met = max(before, key=lambda earlier: earlier.end, default=None)
        if met is not None and interval.start < met.end:
            yield met, interval
        for half in halves:
            if half not in furthest or furthest[half].end < interval.end:
                furthest[half] = interval


def _order(interval: Interval) -> tuple:
    return interval.start, interval.end, interval.side or "", interval.action
