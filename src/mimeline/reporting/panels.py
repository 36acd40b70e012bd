"""Scores over cluster counts and betas: curves through the configured point, the grid as a map."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pandas as pd

from mimeline.reporting.drawing import Scale, curve, ticks

WIDTH, HEIGHT, LEFT, RIGHT, TOP, FOOT = 430, 230, 52, 14, 10, 42
DIGITS = {"f1": 3, "bic": 0, "stability": 2}  # that a score is shown with
HOPELESS = 0.15  # below the best macro-F1: not drawn
PAD = 0.04  # of the width, between the outermost points and the edges
PARTS = 50  # of 1: the axes of macro-F1 and stability begin at one of them


class Point(NamedTuple):
    n_clusters: int
    beta: float

    def __str__(self) -> str:
        plural = "" if self.n_clusters == 1 else "s"
        return f"{self.n_clusters} cluster{plural} with beta {self.beta:g}"


@dataclass(frozen=True)
class Mark:
    x: float
    y: float
    kind: str  # best, configured, or nothing of both
    title: str


@dataclass(frozen=True)
class Trace:
    """A region's line: means over the seeds, and the area between the least and the greatest."""

    region: str
    path: str
    area: str
    marks: list[Mark]


@dataclass(frozen=True)
class Panel:
    title: str
    x_title: str
    traces: list[Trace]
    x_ticks: list[tuple[float, str]]
    y_ticks: list[tuple[float, str]]
    width: float = WIDTH
    height: float = HEIGHT
    floor: float = HEIGHT - FOOT
    left: float = LEFT
    right: float = WIDTH - RIGHT


@dataclass(frozen=True)
class Cell:
    """shade in [0, 1], 1 the best value. text: the value, short; title: in full."""

    text: str
    shade: float
    favoured: bool
    configured: bool
    title: str


@dataclass(frozen=True)
class Grid:
    """rows: a beta each, the largest on top; columns: numbers of clusters."""

    title: str
    counts: list[int]
    rows: list[tuple[str, list[Cell]]]


def panels(
    points: Mapping[str, pd.DataFrame], score: str, title: str, configured: Mapping[str, Point]
) -> list[Panel]:
    """A score against the number of clusters and against beta, the other as configured.

    points: by region, of `summary`.
    """
    found = []
    for along, across in (("n_clusters", "beta"), ("beta", "n_clusters")):
        lines = {
            region: own[own[across] == getattr(configured[region], across)].sort_values(along)
            for region, own in points.items()
        }
        found.append(_panel(lines, along, score, title, configured))
    return found


def _panel(lines, along, score, title, configured) -> Panel:
    everything = pd.concat(list(lines.values()))
    places = sorted(set(everything[along]))
    view = _logarithmic(places) if along == "beta" else np.asarray
    low, high = float(view(places[0])), float(view(places[-1]))
    pad = PAD * (high - low or 1.0)
    x = Scale(low - pad, high + pad, LEFT, WIDTH - RIGHT)
    bottom, top = _range(everything, score)
    y = Scale(bottom, top, HEIGHT - FOOT, TOP)
    traces = [
        _trace(region, line, along, score, configured[region], x, y, view)
        for region, line in lines.items()
    ]
    fixed = _fixed(along, {region: configured[region] for region in lines})
    name = "beta, nats (logarithmic)" if along == "beta" else "clusters"
    return Panel(
        title=title,
        x_title=f"{name} — at {fixed}",
        traces=traces,
        x_ticks=[(x(float(view(place))), f"{place:g}") for place in places],
        y_ticks=[(y(tick), f"{tick:,g}") for tick in ticks(bottom, top, 4)],
    )


def _logarithmic(betas: Sequence[float]) -> Callable:
    """beta → log2 beta; 0, which has none, lies as far below the least as others lie apart."""
    positive = np.array([beta for beta in betas if beta > 0])
    ratios = positive[1:] / positive[:-1]
    step = float(np.median(ratios)) if len(ratios) else 2.0
    zero = positive[0] / step if len(positive) else 1.0
    return lambda beta: np.log2(np.where(np.equal(beta, 0), zero, beta))


def _fixed(along: str, configured: Mapping[str, Point]) -> str:
    """What does not vary along a panel: 9 clusters; beta brow 20, eye 30."""
    across = "n_clusters" if along == "beta" else "beta"
    values = {region: f"{getattr(point, across):g}" for region, point in configured.items()}
    same = len(set(values.values())) == 1
    said = next(iter(values.values())) if same else ", ".join(" ".join(v) for v in values.items())
    return f"{said} clusters" if along == "beta" else f"beta {said}"


def _range(rows: pd.DataFrame, score: str) -> tuple[float, float]:
    """From the worst to the best, never empty; what is hopeless does not flatten the rest."""
    low, high = float(rows[f"{score}_low"].min()), float(rows[f"{score}_high"].max())
    if score == "bic":
        return min(low, 0.0), high * 1.05 or 1.0
    floor = max(low, high - HOPELESS) if score == "f1" else low
    return max(min(math.floor(floor * PARTS), PARTS - 1) / PARTS, 0.0), 1.0


def _trace(region, line, along, score, configured, x, y, view) -> Trace:
    xs = view(line[along].to_numpy("float64"))
    values = line[score].to_numpy("float64")
    low, high = (line[f"{score}_{end}"].to_numpy("float64") for end in ("low", "high"))
    area = curve([*xs, *xs[::-1]], [*high, *low[::-1]], x, y) + "Z"
    best = values.argmin() if score == "bic" else values.argmax()
    marks = []
    for place, (at, value) in enumerate(zip(line[along], values, strict=True)):
        if not min(y.low, y.high) <= value <= max(y.low, y.high):
            continue
        kinds = [("best", place == best), ("configured", at == getattr(configured, along))]
        kind = " ".join(name for name, here in kinds if here)
        name = f"beta {at:g}" if along == "beta" else f"{at} clusters"
        title = f"{region}, {name}: {_text(value, score)}" + (f" ({kind})" if kind else "")
        marks.append(Mark(x(xs[place]), y(value), kind, title))
    return Trace(region, curve(xs, values, x, y), area, marks)


def grid(points: pd.DataFrame, score: str, title: str, configured: Point) -> Grid:
    """A region's score at every point. points: of `summary`."""
    table = points.pivot(index="beta", columns="n_clusters", values=score).sort_index()
    values = table.to_numpy("float64")
    good = -values if score == "bic" else values
    lost = (good.max() - good) / ((good.max() - good.min()) or 1.0)
    shades = 1 - np.sqrt(lost)  # what is nearly best is told apart from the best
    best = favourite(points, score)
    rows = []
    for row, beta in reversed(list(enumerate(table.index))):
        cells = []
        for column, count in enumerate(table.columns):
            here, value = Point(int(count), float(beta)), float(values[row, column])
            cells.append(
                Cell(
                    text=_short(value, score),
                    shade=round(float(shades[row, column]), 3),
                    favoured=here == best,
                    configured=here == configured,
                    title=f"{here}: {_text(value, score)}",
                )
            )
        rows.append((f"{beta:g}", cells))
    return Grid(title, [int(count) for count in table.columns], rows)


def favourite(points: pd.DataFrame, score: str) -> Point:
    """The point that a score, as it is shown, favours: of equals, fewest clusters, least beta.

    Points whose BIC lies within what starts do to the lowest are alike: the stablest is favoured.
    points: of `summary`.
    """
    if score == "bic":
        lowest = points.loc[points["bic"].idxmin()]
        points = points[points["bic"] <= lowest["bic_high"]]
        score = "stability" if points["stability"].notna().all() else score
    values = points[score] if score == "bic" else -points[score]
    best = points.loc[values.round(DIGITS[score]).idxmin()]
    return Point(int(best["n_clusters"]), float(best["beta"]))


def _text(value: float, score: str) -> str:
    return f"{value:,.{DIGITS[score]}f}"


def _short(value: float, score: str) -> str:
    if score == "bic":
        return f"{value:.0f}" if value < 999.5 else f"{value / 1000:.{int(value < 9950)}f}k"
    return _text(value, score).removeprefix("0")
