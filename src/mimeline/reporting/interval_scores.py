"""How many annotated intervals are right, and how far their edges lie off: a table."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from mimeline.reporting import words

UNBIASED = 0.05  # frames: less is neither early nor late


@dataclass(frozen=True)
class Value:
    """A score in words, its 95 % interval, and a remark; each may be empty."""

    text: str = ""
    spread: str = ""
    remark: str = ""


@dataclass(frozen=True)
class Line:
    """A variant on a region. region: empty where the line above is of the same · found, true: how
    many intervals · start, end: how far off, in frames · within: the share of
    edges that are two frames off at most."""

    region: str
    variant: str
    found: int
    true: int
    precision: Value
    recall: Value
    start: Value
    end: Value
    within: Value


def lines(metrics: pd.DataFrame, regions: Mapping[str, str], variants: Sequence[str]) -> list[Line]:
    """A line for each variant that has intervals scored, region by region.

    metrics: the `metrics` table. regions: what each is called.
    """
    found = []
    for region, name in regions.items():
        of_region = metrics[metrics["metric"].str.endswith(f"_{region}")]
        for variant in variants:
            rows = of_region[of_region["variant"] == variant].itertuples()
            own = {row.metric.removesuffix(f"_{region}"): row for row in rows}
            if "segment_f1" in own:
                found.append(_line(name, variant, own))
                name = ""
    return found


def _line(region: str, variant: str, own: Mapping) -> Line:
    precision, recall = own.get("segment_precision"), own.get("segment_recall")
    return Line(
        region,
        variant,
        int(precision.n) if precision else 0,
        int(recall.n) if recall else 0,
        _value(precision),
        _value(recall),
        _value(own.get("start_mean"), _lean(own.get("start_bias"))),
        _value(own.get("end_mean"), _lean(own.get("end_bias"))),
        _share(own.get("boundary_within_2")),
    )


def _value(row, remark: str = "") -> Value:
    return Value() if row is None else Value(f"{row.value:.2f}", _spread(row, 1, 2), remark)


def _share(row) -> Value:
    return Value() if row is None else Value(words.percent(row.value), _spread(row, 100, 0))


def _spread(row, scale: float, digits: int) -> str:
    known = pd.notna(row.low) and pd.notna(row.high)
    return f"{scale * row.low:.{digits}f}–{scale * row.high:.{digits}f}" if known else ""


def _lean(row) -> str:
    """Whether edges are found early or late on the average."""
    if row is None:
        return ""
    if abs(row.value) < UNBIASED:
        return "on time"
    return f"{abs(row.value):.2f} {'late' if row.value > 0 else 'early'}"
