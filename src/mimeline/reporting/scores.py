"""How right the annotation is, and how often each action occurs."""

from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from mimeline import tables
from mimeline.annotation.annotate import unmeasured_actions
from mimeline.reporting import words
from mimeline.reporting.dots import DotChart, dot_chart
from mimeline.reporting.interval_scores import Line, lines
from mimeline.vocabulary import ACTIONS, CONTROL_REGIONS, TRACKS, region_actions

VARIANTS = {
    "named": "the timelines as written",
    "oracle": "the same clusters, each named after most of its frames in truth",
    "thresholds": "alone, without clusters: the proposals’ rule on single frames",
    "gmm": "a Gaussian mixture on single frames, named as the oracle is",
}
REGIONS = {"brow": "brow", "eye": "eye (lid)", "mouth": "mouth"}
LIMITS = {"closure": "closure", "gaze": "gaze", "head": "head"}  # the same in every variant
PREFIX, SEGMENTS = "f1_", "segment_f1_"
FEW = 20  # clips: intervals over fewer are too narrow (docs/scores.md)
MOSTLY = 0.995  # share of the frames that is as good as all of them


@dataclass(frozen=True)
class Entry:
    """A line of the table: value and interval per variant, and how many frames count, in words."""

    name: str
    cells: list[tuple[str, str]]
    frames: str


@dataclass(frozen=True)
class Share:
    """How much of the frames shows an action; truth in the same unit, None where not known."""

    action: str
    share: float | None
    truth: float | None
    text: str


@dataclass(frozen=True)
class Scores:
    """chart, entries: of frames; segments, lines: of intervals and their edges.

    against: what is scored against, in words, empty without truth; partly: of how many clips, where
    truth has not all. caution: where truth has few clips.
    """

    against: str
    partly: str
    caution: str
    chart: DotChart | None
    entries: list[Entry]
    segments: DotChart | None
    lines: list[Line]
    variants: dict[str, str]
    mean: float | None
    reason: str
    shares: dict[str, list[Share]]
    largest: float


def scores(metrics: str | Path, frames: pd.DataFrame, truth: pd.DataFrame | None) -> Scores:
    """metrics: of the annotation; frames, truth: `frames` tables, truth None where not known."""
    rows = tables.read(tables.METRICS, metrics)
    reason = (tables.reason(metrics) or "nothing was scored") if rows.empty else ""
    named = rows[rows["variant"] == "named"].set_index("metric")["value"]
    means = [named[PREFIX + region] for region in REGIONS if PREFIX + region in named]
    clustered = rows["metric"].str.endswith(tuple(f"_{key}" for key in REGIONS))
    drawn = rows[clustered | (rows["variant"] == "named")]
    present = {v: about for v, about in VARIANTS.items() if v in set(rows["variant"])}
    shares, largest = _shares(frames, truth)
    partly = _partly(frames, truth)
    return Scores(
        against="" if truth is None else f"the truth{partly and ' of '}{partly}",
        partly=partly,
        caution=_caution(truth),
        chart=dot_chart(_of(drawn, PREFIX), PREFIX, REGIONS | LIMITS, list(VARIANTS)),
        entries=_entries(drawn, list(present)),
        segments=dot_chart(_of(drawn, SEGMENTS), SEGMENTS, REGIONS | LIMITS, list(VARIANTS)),
        lines=lines(drawn, REGIONS | LIMITS, list(present)),
        variants=present,
        mean=float(pd.Series(means).mean()) if means else None,
        reason=reason,
        shares=shares,
        largest=largest,
    )


def _partly(frames: pd.DataFrame, truth: pd.DataFrame | None) -> str:
    """Of how many of the clips truth is, in words; empty where of all, or of none."""
    kept = set(frames["clip_id"])
    known = kept if truth is None else kept & set(truth["clip_id"])
    if len(known) == len(kept):
        return ""
    return f"{words.count(len(known))} of the {words.clips(len(kept))}"


def _caution(truth: pd.DataFrame | None) -> str:
    clips = FEW if truth is None else truth["clip_id"].nunique()
    if clips >= FEW:
        return ""
    if clips == 1:
        return "One clip alone tells nothing of the others: there are no intervals."
    return f"{words.clips(clips)} tell little of the others: intervals over so few are too narrow."


def _of(rows: pd.DataFrame, prefix: str) -> pd.DataFrame:
    return rows[rows["metric"].isin([prefix + key for key in REGIONS | LIMITS])]


def _entries(rows: pd.DataFrame, variants: list[str]) -> list[Entry]:
    by_key = {(m.metric, m.variant): m for m in rows.itertuples()}
    entries = []
    for key, name in (REGIONS | LIMITS).items():
        own = [by_key.get((PREFIX + key, variant)) for variant in variants]
        if any(own):
            cells = [_cell(row) for row in own]
            entries.append(Entry(name, cells, _frames([row.n for row in own if row])))
    return entries


def _frames(counts: list[int]) -> str:
    """counts: of each variant, the timelines as written first, which may not know every frame."""
    known, most = counts[0], max(counts)
    return words.count(known) + (f" of {words.count(most)}" if known < MOSTLY * most else "")


def _cell(row) -> tuple[str, str]:
    if row is None or pd.isna(row.value):
        return "", ""
    known = pd.notna(row.low) and pd.notna(row.high)
    return f"{row.value:.3f}", f"{row.low:.3f}–{row.high:.3f}" if known else ""


def _shares(
    frames: pd.DataFrame, truth: pd.DataFrame | None
) -> tuple[dict[str, list[Share]], float]:
    """By control region; of truth only where it is of all clips, or it could not be compared."""
    if frames.empty:
        return {}, 1.0
    found = _means(frames)
    known = pd.Series(dtype="float64")
    if truth is not None and not _partly(frames, truth):
        known = _means(truth[truth["clip_id"].isin(frames["clip_id"].unique())])
    shares: dict[str, list[Share]] = {}
    for region in CONTROL_REGIONS:
        shares[region] = []
        for action in region_actions(region):
            share, true = found.get(action), known.get(action)
            share = None if share is None else float(share)
            true = None if true is None else float(true)
            text = "not measured" if share is None else words.percent(share)
            shares[region].append(Share(action, share, true, text))
    largest = max([s.share or 0 for own in shares.values() for s in own])
    largest = max([largest, *(s.truth or 0 for own in shares.values() for s in own)])
    return shares, largest or 1.0


def _means(frames: pd.DataFrame) -> pd.Series:
    """Each action's share of the frames of which it is known; NaN where it is not measured."""
    shares = frames[list(ACTIONS)].astype("Float64").mean().astype("float64")
    return shares.drop([name for track in TRACKS for name in unmeasured_actions(frames, track)])
