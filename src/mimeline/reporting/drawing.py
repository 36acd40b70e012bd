"""Geometry of the pictures: scales, ticks and curves. The templates hold the SVG."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Scale:
    """Maps [low, high] of the data to [start, stop] of the picture."""

    low: float
    high: float
    start: float
    stop: float

    def __call__(self, value: float) -> float:
        span = self.high - self.low or 1.0
        return round(self.start + (value - self.low) / span * (self.stop - self.start), 1)


def ticks(low: float, high: float, count: int = 5) -> list[float]:
    """Round numbers within [low, high], about `count` of them."""
    if not high > low:
        return [low]
    rough = (high - low) / count
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(power * m for m in (1, 2, 2.5, 5, 10) if power * m >= rough * 0.999)
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [round(number * step, 10) for number in range(first, last + 1)]


def curve(xs: Sequence[float], ys: Sequence[float], x: Scale, y: Scale) -> str:
    """The `d` of an SVG path through the points; a point that is not finite breaks the line."""
    words, pen_down = [], False
    for at, value in zip(xs, ys, strict=True):
        if not np.isfinite(value):
            pen_down = False
            continue
        words.append(f"{'L' if pen_down else 'M'}{x(at):g} {y(value):g}")
        pen_down = True
    return "".join(words)


def second_ticks(start_s: float, end_s: float, most: int = 12) -> list[float]:
    """Whole seconds within [start_s, end_s], every 1, 2, 5, 10 … so that there are few."""
    step = next(
        s for s in (1, 2, 5, 10, 15, 30, 60, 120, 300, 10**6) if end_s - start_s <= most * s
    )
    return [float(s) for s in range(math.ceil(start_s), math.floor(end_s) + 1) if s % step == 0]
