"""Two pictures of the ablation study: actions that conflict, and a head that goes with the eyes."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from mimeline.reporting.drawing import Scale, curve, second_ticks, ticks
from mimeline.reporting.paired import Estimate
from mimeline.reporting.timelines import Stretch, stretches, within

WIDTH, HEIGHT, LEFT, RIGHT, TOP, FOOT = 720, 168, 58, 76, 44, 22
ROW = 16  # height of a row of what is asked for
CURVES = {"brow up": "browInnerUp", "brow down": "browDown", "smile": "mouthSmile"}
EDGE, MARGIN = 300, 40  # of a cloud


@dataclass(frozen=True)
class Panel:
    """rows: (name, y, what is asked for) · traces: (letter, name, path, y of the name)."""

    title: str
    rows: list[tuple[str, float, list[Stretch]]]
    traces: list[tuple[str, str, str, float]]
    x_ticks: list[tuple[float, str]]
    y_ticks: list[tuple[float, str]]
    width: float = WIDTH
    height: float = HEIGHT
    left: float = LEFT
    right: float = WIDTH - RIGHT
    floor: float = HEIGHT - FOOT
    row: float = ROW - 3


@dataclass(frozen=True)
class Cloud:
    """points: (x, y); line: the ends of the slope, x and y of each; None where there is none."""

    title: str
    slope: Estimate | None
    points: list[tuple[float, float]]
    line: tuple[float, float, float, float] | None
    x_ticks: list[tuple[float, str]]
    y_ticks: list[tuple[float, str]]
    edge: float = EDGE
    margin: float = MARGIN


def telling(asked: pd.DataFrame, first: pd.DataFrame, second: pd.DataFrame) -> str:
    """The timeline on which two variants differ as they mostly do: the median one.

    asked: a `frames` table of raised brows; first, second: what is found in what either made. They
    differ by the share of the raised brow that is found.
    """
    keys = ["clip_id", "frame"]
    raised = asked.loc[asked["BrowUp"].fillna(False).astype(bool), keys]
    shares = [
        raised.merge(own[[*keys, "BrowUp"]], on=keys).astype({"BrowUp": "float64"})
        .groupby("clip_id")["BrowUp"].mean()
        for own in (first, second)
    ]  # fmt: skip
    apart = (shares[0] - shares[1]).sort_values(kind="stable")
    return str(apart.index[len(apart) // 2])


def panel(title: str, asked: pd.DataFrame, made: pd.DataFrame, side: str, fps: float) -> Panel:
    """Brow and smile of one timeline; asked, made: its rows of the tables `frames` and `motion`."""
    end = len(made)
    x = Scale(0, end, LEFT, WIDTH - RIGHT)
    names = {name: channel + side.capitalize() for name, channel in CURVES.items()}
    names["brow up"] = CURVES["brow up"]
    values = {name: made[channel].to_numpy("float64") for name, channel in names.items()}
    reach = max(0.75, float(np.nanmax(list(values.values()))))
    y = Scale(0, reach, HEIGHT - FOOT, TOP)
    rows = [
        (track, float(ROW * row), within(stretches(asked, track), (fps, 0, end), x, "asked for"))
        for row, track in enumerate(("brow", "mouth"))
    ]
    traces = [
        (letter, name, curve(range(end), own, x, y), float(TOP + 18 + 17 * place))
        for place, (letter, (name, own)) in enumerate(zip("abc", values.items(), strict=True))
    ]
    seconds = [(x(s * fps), f"{s:g} s") for s in second_ticks(0, end / fps)]
    return Panel(title, rows, traces, seconds, [(y(t), f"{t:g}") for t in ticks(0, reach, 3)])


def clouds(pulls: Mapping[str, pd.DataFrame], slopes: Mapping[str, Estimate | None]) -> list[Cloud]:
    """Of each title how much farther eyes and head go (`coupling.pulls`), on one scale, degrees."""
    apart = {
        title: np.degrees(own[["gaze", "head"]].to_numpy("float64")) for title, own in pulls.items()
    }
    every = np.abs(np.concatenate(list(apart.values())))
    wide, high = (max(float(np.ceil(reach)), 1.0) for reach in every.max(axis=0, initial=1.0))
    x, y = Scale(-wide, wide, MARGIN, EDGE - 6), Scale(-high, high, EDGE - MARGIN, 6)
    x_ticks = [(x(t), _degrees(t)) for t in ticks(-wide, wide, 4)]
    y_ticks = [(y(t), _degrees(t)) for t in ticks(-high, high, 4)]
    found = []
    for title, own in apart.items():
        slope = slopes[title]
        reach = min(wide, high / max(abs(slope.value), 1e-9)) if slope else 0.0
        line = None
        if slope:
            line = (x(-reach), y(-reach * slope.value), x(reach), y(reach * slope.value))
        points = [(x(gaze), y(head)) for gaze, head in own]
        found.append(Cloud(title, slope, points, line, x_ticks, y_ticks))
    return found


def _degrees(angle: float) -> str:
    return f"{angle:g}°".replace("-", "−")
