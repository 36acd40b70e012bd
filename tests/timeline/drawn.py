"""Timelines of any kind, drawn for property tests."""

from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

from hypothesis import strategies as st

from mimeline.timeline.timeline import SIDES, SOURCES, Interval, Timeline
from mimeline.vocabulary import TRACKS, track_actions

RATES = [Fraction(24000, 1001), Fraction(25), Fraction(30000, 1001), Fraction(30), Fraction(60)]
HOURS = 5


@st.composite
def timelines(draw, fps: Fraction, n_frames: int | None = None, names=None) -> Timeline:
    """Any timeline at fps: sided or not, unmeasured and neutral tracks, intervals that touch."""
    n_frames = n_frames or draw(st.integers(1, 200))
    measured = draw(st.sets(st.sampled_from(TRACKS)))
    tracks = {}
    for track in sorted(measured):
        intervals = []
        for side in draw(st.sampled_from([(None,), ("left",), SIDES, (None, *SIDES)])):
            drawn = draw(_intervals(track, side, n_frames))
            intervals += [i for i in drawn if not any(i.excludes(other) for other in intervals)]
        tracks[track] = intervals
    clip_id = draw(st.text("abcXYZ019_-.", min_size=1, max_size=12) if names is None else names)
    return Timeline(clip_id, fps, n_frames, tracks)


@st.composite
def _intervals(draw, track: str, side: str | None, n_frames: int) -> list[Interval]:
    edges = sorted(draw(st.sets(st.integers(0, n_frames), max_size=8)))
    spans = [span for span in pairwise(edges) if draw(st.booleans())]
    return [
        Interval(
            draw(st.sampled_from(track_actions(track))),
            start,
            end,
            side,
            draw(st.sampled_from(SOURCES)),
            draw(st.none() | st.integers(0, 40)),
            draw(st.none() | st.floats(0, 1)),
        )
        for start, end in spans
    ]


def kept(timeline: Timeline, lost: tuple[str, ...]) -> Timeline:
    """The timeline without what a file does not keep."""
    plain = {"source": "human", "cluster": None, "confidence": None}
    gone = {name: plain[name] for name in lost if name in plain}
    tracks = {
        track: [replace(interval, **gone) for interval in intervals]
        for track, intervals in timeline.tracks.items()
        if intervals or "neutral tracks" not in lost
    }
    return replace(timeline, tracks=tracks)


def told_besides(timeline: Timeline, lost: tuple[str, ...]) -> dict:
    """What read must be told of a clip whose file does not tell it."""
    told = {
        "clip": ("clip_id", timeline.clip_id),
        "clips without intervals": ("clip_id", timeline.clip_id),
        "fps": ("fps", timeline.fps),
        "n_frames": ("n_frames", timeline.n_frames),
    }
    return dict(told[name] for name in lost if name in told)
