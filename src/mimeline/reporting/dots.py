"""A chart of dots with whiskers: a row per region, a dot per variant, on one scale up to 1."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from mimeline.reporting import words
from mimeline.reporting.drawing import Scale, ticks

LEFT, RIGHT, WIDTH = 96, 48, 720
HIGHEST_START = 0.8  # of the scale, which may leave out what is below every whisker
LINE, GAP, TOP, FOOT = 15, 13, 8, 26


@dataclass(frozen=True)
class Dot:
    """low, high: the whisker's ends, equal to x where no interval is known."""

    variant: str
    x: float
    low: float
    high: float
    y: float
    label: str
    title: str


@dataclass(frozen=True)
class Group:
    name: str
    y: float
    top: float
    bottom: float
    dots: list[Dot]


@dataclass(frozen=True)
class DotChart:
    groups: list[Group]
    variants: list[str]
    ticks: list[tuple[float, str]]
    width: float
    height: float
    floor: float
    left: float
    right: float


def dot_chart(
    metrics: pd.DataFrame, prefix: str, names: Mapping[str, str], variants: Sequence[str]
) -> DotChart | None:
    """metrics: the `metrics` table, whose metric is prefix and a key of names (what it is called).

    variants: drawn in this order, from the top. None where there is nothing to draw.
    """
    by_key = {(m.metric, m.variant): m for m in metrics.itertuples() if pd.notna(m.value)}
    least = min((_low(row) for row in by_key.values() if row.variant in variants), default=0.0)
    start = min(max(math.floor((least - 0.02) * 10) / 10, 0.0), HIGHEST_START)
    x = Scale(start, 1.0, LEFT, WIDTH - RIGHT)
    groups, at = [], float(TOP)
    present = [v for v in variants if any(variant == v for _, variant in by_key)]
    for key, name in names.items():
        own = [v for v in present if (f"{prefix}{key}", v) in by_key]
        if not own:
            continue
        dots = []
        for place, variant in enumerate(own):
            row = by_key[f"{prefix}{key}", variant]
            spread = pd.notna(row.low) and pd.notna(row.high)
            low, high = (row.low, row.high) if spread else (row.value, row.value)
            text = words.score(row.value)
            title = f"{name}, {variant}: {text}"
            title += f" ({words.score(low)} to {words.score(high)})" if spread else ""
            y = at + LINE * (place + 0.5)
            dots.append(Dot(variant, x(row.value), x(low), x(high), y, text, title))
        bottom = at + LINE * len(own)
        groups.append(Group(name, (at + bottom) / 2, at - GAP / 2, bottom + GAP / 2, dots))
        at = bottom + GAP
    if not groups:
        return None
    marks = [(x(t), f"{t:g}") for t in ticks(start, 1.0)]
    floor = at - GAP / 2
    return DotChart(groups, present, marks, WIDTH, floor + FOOT, floor, LEFT, WIDTH - RIGHT)


def _low(row) -> float:
    return row.low if pd.notna(row.low) else row.value
