"""Labels spent against macro-F1: how good the names are after so many intervals looked at."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.reporting.drawing import Scale, curve, ticks
from mimeline.vocabulary import SERIES_REGIONS

WAYS = {  # variants that are curves → how their looks are chosen
    "active_unproposed": "looks where they help most",
    "random_unproposed": "looks at random clusters; 95 % of the orders lie in the band",
    "in_turn_unproposed": "each cluster in turn",
    "active": "looks where they help most, names proposed before",
}
BANDED = "random_unproposed"
MEAN, PREFIX = "f1", "f1_"
LARGE, SMALL = (720, 240), (226, 140)  # width and height of a plot
LEFT, RIGHT, TOP, FOOT = 46, 14, 8, 26
LEAST_SPAN = 0.04  # of the scale, so that curves that hardly rise look so
CLOSE = 0.01  # to what all looks give


@dataclass(frozen=True)
class Plot:
    """lines: (variant, path). band: a closed path about the random line, or empty.

    proposed: where the proposals alone stand; ceiling: the height of the best names; either None.
    """

    name: str
    lines: list[tuple[str, str]]
    band: str
    proposed: tuple[float, float] | None
    ceiling: float | None
    x_ticks: list[tuple[float, str]]
    y_ticks: list[tuple[float, str]]
    width: float
    height: float
    floor: float
    left: float
    right: float


@dataclass(frozen=True)
class Labelling:
    """plots: the mean of the regions first, larger. facts: per region its name and the scores
    before any look, after all of them, and of the best names."""

    plots: list[Plot]
    facts: list[tuple[str, list[float | None]]]
    ways: dict[str, str]
    looks: int
    sentence: str


def labelling(metrics: str | Path) -> Labelling | None:
    """metrics: of the labelling. None where there are none, since no truth is known."""
    rows = tables.read(tables.METRICS, metrics).sort_values("n", kind="stable")
    present = set(rows["metric"])
    names = {MEAN: "mean"} | {PREFIX + region: region for region in SERIES_REGIONS}
    names = {metric: name for metric, name in names.items() if metric in present}
    curves = rows[rows["variant"].isin(WAYS)]
    if curves.empty or MEAN not in names:
        return None
    if len(names) == 2:  # the mean of one region is the region
        names = {MEAN: list(names.values())[1]}
    parts = {name: rows[rows["metric"] == metric] for metric, name in names.items()}
    first, *others = parts
    scale = _span([parts[name] for name in others])  # one for all, to be compared
    plots = [_plot(parts[first], first, LARGE, _span([parts[first]]))]
    plots += [_plot(parts[name], name, SMALL, scale) for name in others]
    facts = [
        (name, [_one(own, variant) for variant in ("proposed", "person", "oracle")])
        for name, own in parts.items()
    ]
    ways = {way: about for way, about in WAYS.items() if way in set(rows["variant"])}
    looks = int(curves["n"].max())
    return Labelling(plots, facts, ways, looks, _sentence(parts[first], looks))


def looks_needed(n: np.ndarray, values: np.ndarray, close: float) -> int:
    """The looks from which on a curve is no more than `close` below its end.

    n, values (m,): labels spent, rising, and scores.
    """
    below = np.flatnonzero(values < values[-1] - close)
    return int(n[below[-1] + 1] if len(below) else n[0])


def _sentence(rows: pd.DataFrame, every: int) -> str:
    """What the curves of a metric tell; every: all looks."""
    spent = {
        way: looks_needed(own["n"].to_numpy(), own["value"].to_numpy(), CLOSE)
        for way in WAYS
        if len(own := rows[rows["variant"] == way])
    }
    if not (best := spent.get("active_unproposed")):
        return ""
    close = f"come within {CLOSE} of what all {every} give"
    parts = [f"{best} looks, chosen where they help most, {close}"]
    others = {"random_unproposed": "chosen at random", "in_turn_unproposed": "taken in turn"}
    parts += [f"{how}, it takes {spent[way]}" for way, how in others.items() if way in spent]
    told = "; ".join(parts) + "."
    if "active" in spent:
        told += f" Where names are proposed before, it takes {spent['active'] or 'none'}."
    return told


def _plot(rows: pd.DataFrame, name: str, size: tuple[int, int], scale: tuple[float, float]) -> Plot:
    width, height = size
    most = int(rows["n"].max())
    x = Scale(0, most, LEFT, width - RIGHT)
    y = Scale(*scale, height - FOOT, TOP)
    by_way = {way: rows[rows["variant"] == way] for way in reversed(WAYS)}
    lines = [(w, curve(own["n"], own["value"], x, y)) for w, own in by_way.items() if len(own)]
    spread = by_way[BANDED].dropna(subset=["low", "high"])
    edge = [*spread[["n", "high"]].to_numpy(), *spread[["n", "low"]].to_numpy()[::-1]]
    band = curve(*zip(*edge, strict=True), x, y) + "Z" if edge else ""
    alone, best = _one(rows, "proposed"), _one(rows, "oracle")
    return Plot(
        name,
        lines,
        band,
        None if alone is None else (x(0), y(alone)),
        None if best is None else y(best),
        [(x(t), f"{t:g}") for t in ticks(0, most, 6 if size == LARGE else 3)],
        [(y(t), f"{t:g}") for t in ticks(*scale)],
        width,
        height,
        height - FOOT,
        LEFT,
        width - RIGHT,
    )


def _one(rows: pd.DataFrame, variant: str) -> float | None:
    own = rows.loc[rows["variant"] == variant, "value"]
    return float(own.iloc[-1]) if len(own) else None


def _span(parts: Sequence[pd.DataFrame]) -> tuple[float, float]:
    """The scale's ends: in hundredths, a little around all that is drawn, at most 1."""
    if not parts:
        return 0.0, 1.0
    rows = pd.concat(parts)
    drawn = rows[rows["variant"].isin([*WAYS, "proposed", "oracle"])]
    values = drawn[["value", "low", "high"]].to_numpy("float64")
    high = min(1.0, np.ceil((np.nanmax(values) + 0.002) * 100) / 100)
    low = np.floor(min(np.nanmin(values) - 0.002, high - LEAST_SPAN) * 100 + 1e-6) / 100
    return max(0.0, float(low)), float(high)
