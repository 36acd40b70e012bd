"""Motion that a model made, as curves and as a face, over the timeline that it was asked for."""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.reporting import words
from mimeline.reporting.drawing import Scale, curve, second_ticks
from mimeline.reporting.filmstrip import Place, places
from mimeline.reporting.side_by_side import SideBySide, side_by_side
from mimeline.reporting.stand_in import StandIn
from mimeline.reporting.timelines import Stretch, choose, stretches, within
from mimeline.vocabulary import CHANNELS, TRACKS

WIDTH, LEFT, RIGHT, TOP, ROW, PLOT, HEAD = 860, 112, 96, 6, 64, 54, 13
LONGEST_S = 10.0
# (name, channel): what a track's actions show in; a channel of two sides without its side
CURVES: dict[str, tuple[tuple[str, str], ...]] = {
    "brow": (("inner up", "browInnerUp"), ("down", "browDown")),
    "lid": (("squint", "eyeSquint"), ("wide", "eyeWide")),
    "closure": (("blink", "eyeBlink"),),
    "mouth": (("smile", "mouthSmile"), ("frown", "mouthFrown")),
    "gaze_h": (("↑ left", "gaze_left"),),
    "gaze_v": (("↑ up", "gaze_up"),),
    "head_h": (("↑ left", "head_yaw_left"),),
    "head_v": (("↑ up", "head_pitch_up"),),
}


@dataclass(frozen=True)
class Trace:
    """A channel's curves: of the generated motion and, fainter, of the real clip."""

    line: str
    name: str
    made: str
    real: str
    y: float


@dataclass(frozen=True)
class Plot:
    name: str
    y: float
    bands: list[Stretch]
    traces: list[Trace]
    zero: float | None
    scale: str


@dataclass(frozen=True)
class Asked:
    """A clip whose timeline was asked for.

    edge: of the strips' pictures; strips: "made" and "real" → where which picture (a data URI)
    stands.
    """

    clip_id: str
    about: str
    plots: list[Plot]
    ticks: list[tuple[float, str]]
    width: float
    height: float
    left: float
    end: float
    edge: float
    strips: dict[str, list[tuple[Place, str]]]
    film: SideBySide


def pictures(
    generated: str | Path,
    motions: Sequence[str | Path],
    frames: pd.DataFrame,
    clips: pd.DataFrame,
    side: str,
    wanted: int,
    stand_in: StandIn,
) -> list[Asked]:
    """A few requested timelines with the motion that was made for them.

    generated: `motion`, clip_id being the clip whose timeline (in frames) was asked for; motions:
    the real clips' `motion`; clips: `clips`, for the frame rate; stand_in: who acts them out.
    """
    made = tables.read(tables.MOTION, generated)
    if made.empty:
        return []
    asked = frames[frames["clip_id"].isin(made["clip_id"].unique())]
    ids = choose(_as_intervals(asked), sorted(asked["clip_id"].unique()), wanted)
    columns = ["clip_id", "frame", "valid", *CHANNELS]
    parts = [tables.read(tables.MOTION, path, columns) for path in motions]
    real = pd.concat([part[part["clip_id"].isin(ids)] for part in parts])
    rates = {c.clip_id: Fraction(int(c.fps_num), int(c.fps_den)) for c in clips.itertuples()}
    return [
        _picture(
            clip,
            rates.get(clip, Fraction(30)),
            made[made["clip_id"] == clip],
            real[real["clip_id"] == clip],
            asked[asked["clip_id"] == clip],
            side,
            stand_in,
        )
        for clip in ids
    ]


def _as_intervals(frames: pd.DataFrame) -> pd.DataFrame:
    runs = [
        (clip, action)
        for clip, own in frames.groupby("clip_id")
        for track in TRACKS
        for action, _, _ in stretches(own, track)
    ]
    return pd.DataFrame(runs, columns=["clip_id", "action"])


def _picture(
    clip: str,
    rate: Fraction,
    made: pd.DataFrame,
    real: pd.DataFrame,
    asked: pd.DataFrame,
    side: str,
    stand_in: StandIn,
) -> Asked:
    fps = float(rate)
    end = min(int(made["frame"].max()) + 1, int(LONGEST_S * fps))
    x = Scale(0, end, LEFT, WIDTH - RIGHT)
    plots = []
    for track in TRACKS:
        channels = [(name, _sided(base, side)) for name, base in CURVES[track]]
        if made[[channel for _, channel in channels]].isna().all(axis=None):
            continue
        plots.append(_plot(track, channels, TOP + ROW * len(plots), end, made, real, asked, x, fps))
    ticks = [(x(s * fps), f"{s:g}") for s in second_ticks(0, end / fps)]
    about = f"{end / fps:.1f} s at {fps:g} frames per second"
    along = places(0, end, x)
    runs = [[run for run in stretches(asked, track) if run[1] < end] for track in TRACKS]
    film = side_by_side(stand_in, made, real, runs, end, rate, [place.frame for place in along])
    strips = {
        name: [(place, uri) for place, uri in zip(along, uris, strict=True) if uri]
        for name, uris in film.strips.items()
    }
    height = TOP + ROW * len(plots)
    return Asked(
        clip, about, plots, ticks, WIDTH, height, LEFT, x(end), along[0].edge, strips, film
    )


def _sided(base: str, side: str) -> str:
    return base if base in CHANNELS else base + side.capitalize()


def _plot(
    track: str,
    channels: list[tuple[str, str]],
    top: float,
    end: int,
    made: pd.DataFrame,
    real: pd.DataFrame,
    asked: pd.DataFrame,
    x: Scale,
    fps: float,
) -> Plot:
    angle = CHANNELS[channels[0][1]].unit == "rad"
    drawn = {
        (which, channel): _values(table, channel, end, angle)
        for which, table in (("made", made), ("real", real))
        for _, channel in channels
    }
    finite = np.concatenate([v[1][np.isfinite(v[1])] for v in drawn.values()])
    reach = float(np.abs(finite).max()) if len(finite) else 1.0
    if angle:
        reach = max(20.0, float(np.ceil(reach / 10) * 10))
        y, scale = Scale(-reach, reach, top + PLOT, top + HEAD), f"±{reach:g}°"
    else:
        reach = max(0.5, float(np.ceil(reach * 4) / 4))
        y, scale = Scale(0, reach, top + PLOT, top + HEAD), f"0–{reach:g}"
    traces = []
    for place, (name, channel) in enumerate(channels):
        at, values = drawn["made", channel]
        then, before = drawn["real", channel]
        traces.append(
            Trace(
                "abc"[place],
                name,
                curve(at, values, x, y),
                curve(then, before, x, y),
                top + 25 + 16 * place,
            )
        )
    bands = within(stretches(asked, track), (fps, 0, end), x, "asked for")
    return Plot(words.TRACK_NAMES[track], top, bands, traces, y(0) if angle else None, scale)


def _values(
    motion: pd.DataFrame, channel: str, end: int, angle: bool
) -> tuple[np.ndarray, np.ndarray]:
    motion = motion[motion["frame"] < end]
    values = motion[channel].to_numpy("float64")
    return motion["frame"].to_numpy("int64"), np.degrees(values) if angle else values


assert set(CURVES) == set(TRACKS)
