"""Macro-F1 over cluster counts and over betas as curves, what has no number beside them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from mimeline.reporting.drawing import Scale, curve, ticks
from mimeline.reporting.paired import Compared, Estimate, Key

WIDTH, HEIGHT, LEFT, RIGHT, TOP, FOOT = 720, 270, 44, 14, 10, 44
PAD = 0.04  # of the width, between the outermost points and the edges
BESIDE = 86  # width of a place for a setting without a number
STEP = 9  # between the regions' dots there
DEPTH = 0.12  # below the best: what is worse stands at the foot, with its value
ROUND = 50  # the scale begins at a multiple of 1 / 50


@dataclass(frozen=True)
class Dot:
    """low, high: the heights of the interval's ends. below: the value of one past the scale."""

    region: str
    x: float
    y: float
    low: float
    high: float
    reference: bool
    below: str
    title: str


@dataclass(frozen=True)
class Line:
    region: str
    path: str
    band: str


@dataclass(frozen=True)
class Chart:
    """ticks: (place, text); beside: (place, words) of the settings without a number; divide: where
    these begin, or None."""

    title: str
    x_title: str
    lines: list[Line]
    dots: list[Dot]
    x_ticks: list[tuple[float, str]]
    y_ticks: list[tuple[float, str]]
    beside: list[tuple[float, list[str]]]
    divide: float | None
    width: float = WIDTH
    height: float = HEIGHT
    floor: float = HEIGHT - FOOT
    left: float = LEFT
    right: float = WIDTH - RIGHT
    top: float = TOP


def chart(
    title: str,
    x_title: str,
    compared: Mapping[str, Compared],
    numbers: Mapping[str, Mapping[float, Key]],
    reference: Mapping[str, float],
    beside: Sequence[tuple[Sequence[str], Key]] = (),
    logarithmic: bool = False,
) -> Chart | None:
    """numbers: by region, the settings that have a number; reference: the configured one.

    beside: (words, setting) of those that have none. None where no region has two numbers.
    """
    places = sorted({number for own in numbers.values() for number in own})
    if len(places) < 2:
        return None
    beside = [(words, key) for words, key in beside if _known(key, compared)]
    view = np.log2 if logarithmic and places[0] > 0 else np.asarray
    ends = float(view(places[0])), float(view(places[-1]))
    pad = PAD * (ends[1] - ends[0])
    edge = WIDTH - RIGHT - BESIDE * len(beside)
    x = Scale(ends[0] - pad, ends[1] + pad, LEFT, edge)
    curves = {
        region: {number: compared[region].score(key) for number, key in sorted(own.items())}
        for region, own in numbers.items()
    }
    apart = [
        (words, {r: own.score(key) for r, own in compared.items() if key in own.counts})
        for words, key in beside
    ]
    every = [s for own in (*curves.values(), *(own for _, own in apart)) for s in own.values()]
    least, best = min(s.low for s in every), max(s.value for s in every)
    low = max(np.floor(max(least, best - DEPTH) * ROUND) / ROUND, 0.0)
    y = Scale(low, 1.0, HEIGHT - FOOT, TOP)
    lines, dots = [], []
    for region, own in curves.items():
        at = view(list(own))
        lines.append(_line(region, at, list(own.values()), x, y))
        for place, (number, score) in zip(at, own.items(), strict=True):
            here = number == reference[region]
            dots.append(_dot(region, f"{number:g}", x(float(place)), score, y, here))
    for number, (words, own) in enumerate(apart):
        centre = edge + BESIDE * (number + 0.5)
        for place, (region, score) in enumerate(own.items()):
            shift = STEP * (place - (len(own) - 1) / 2)
            dots.append(_dot(region, " ".join(words), round(centre + shift, 1), score, y, False))
    return Chart(
        title,
        x_title,
        lines,
        dots,
        [(x(float(view(place))), f"{place:g}") for place in places],
        [(y(tick), f"{tick:g}") for tick in ticks(low, 1.0, 5)],
        [(edge + BESIDE * (n + 0.5), list(words)) for n, (words, _) in enumerate(apart)],
        float(edge) if apart else None,
    )


def _known(key: Key, compared: Mapping[str, Compared]) -> bool:
    return any(key in own.counts for own in compared.values())


def _line(region: str, at, scores: Sequence[Estimate], x: Scale, y: Scale) -> Line:
    ends = [[getattr(score, end) for score in scores] for end in ("high", "low")]
    band = curve([*at, *at[::-1]], [*ends[0], *ends[1][::-1]], x, y) + "Z"
    return Line(region, curve(at, [score.value for score in scores], x, y), band)


def _dot(region: str, name: str, at: float, score: Estimate, y: Scale, here: bool) -> Dot:
    title = f"{region}, {name}: {score.value:.3f} ({score.low:.3f}–{score.high:.3f})"
    title += ", configured" if here else ""
    below = f"{score.value:.2f}" if score.value < y.low else ""
    heights = [y(max(value, y.low)) for value in (score.value, score.low, score.high)]
    return Dot(region, at, *heights, here, below, title)
