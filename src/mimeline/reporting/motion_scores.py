"""The scores of generated motion as a table: variants beside real motion and the paper."""

from dataclasses import dataclass

import pandas as pd

from mimeline.reporting import words
from mimeline.reporting.published import published

REAL = "real"
VARIANT_WORDS = {
    "request": "told the timeline",
    "empty": "told that nothing happens",
    "unconditional": "told nothing",
    REAL: "real motion",
}
METRIC_WORDS = {
    "fid_fm": ("FID, motion", "Fréchet distance of the frames; lower is nearer to real"),
    "fid_delta_fm": ("FID, velocity", "the same of their differences; lower is nearer"),
    "snd": ("SND", "the sum of both distances; lower is nearer"),
    "var": ("variance", "mean over channels; near the real value is better"),
    "velocity": ("velocity", "mean size of a frame’s change; near the real value is better"),
    "jerk": ("jerk", "mean size of the third difference; near the real value is better"),
    "velocity_ratio": ("velocity ratio", "made / real; below 1 motion is smoothed"),
    "jerk_ratio": ("jerk ratio", "made / real; below 1 motion is smoothed"),
}
OF_OTHERS = ("fid_fm", "fid_delta_fm", "snd", "velocity_ratio", "jerk_ratio")


@dataclass(frozen=True)
class Cell:
    """A value, its interval and its number of clips in words; the last two may be empty."""

    value: str
    interval: str = ""
    about: str = ""


@dataclass(frozen=True)
class Row:
    name: str
    about: str
    cells: list[Cell]


@dataclass(frozen=True)
class MotionTable:
    """columns: their heads, each with its number of clips, empty where that differs by row.

    floor: whether the distances of other real clips are known.
    """

    columns: list[tuple[str, str]]
    rows: list[Row]
    floor: bool


def motion_table(metrics: pd.DataFrame, variants: list[str]) -> MotionTable | None:
    """metrics: the `metrics` table of a model; None where it says nothing of the motion itself."""
    rest = metrics[~metrics["metric"].str.startswith("tas")]
    if rest.empty:
        return None
    by_key = {(m.metric, m.variant): m for m in rest.itertuples()}
    counts = {variant: set(own["n"].dropna()) for variant, own in rest.groupby("variant")}
    known = [m for m in METRIC_WORDS if m in set(rest["metric"])]
    other = [m for m in dict.fromkeys(rest["metric"]) if m not in METRIC_WORDS]
    rows = [
        Row(
            *METRIC_WORDS.get(metric, (metric.replace("_", " "), "")),
            [
                *(_cell(by_key.get((metric, v)), len(counts.get(v, ())) > 1) for v in variants),
                _published(metric),
            ],
        )
        for metric in [*known, *other]
    ]
    heads = [(VARIANT_WORDS.get(v, v), _clips(counts.get(v, set()))) for v in variants]
    floor = any((metric, REAL) in by_key for metric in OF_OTHERS)
    return MotionTable([*heads, ("Ma et al. 2025", "100 timelines")], rows, floor)


def _cell(row, counted: bool) -> Cell:
    if row is None or pd.isna(row.value):
        return Cell("–")
    spread = pd.notna(row.low) and pd.notna(row.high)
    interval = f"{words.number(row.low)} to {words.number(row.high)}" if spread else ""
    return Cell(words.number(row.value), interval, words.clips(row.n) if counted else "")


def _published(metric: str) -> Cell:
    """What the paper reports of its own model."""
    values = published()
    if ("Ours", metric) not in values:
        return Cell("–")
    real = values.get((REAL, metric))
    return Cell(f"{values['Ours', metric]:g}", about="" if real is None else f"real {real:g}")


def _clips(counts: set) -> str:
    return words.clips(counts.copy().pop()) if len(counts) == 1 else ""
