"""What the clips show: how many show each thing, and how uneven that is."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from mimeline import tables
from mimeline.clips.description.frequencies import MOVING
from mimeline.reporting import words
from mimeline.vocabulary import ACTIONS

MOST_BARS = 16  # of a kind; of more, the commonest and, after a gap, the rarest
RAREST = 4
KINDS = {  # in the table's words → heading
    "action": "Actions of the catalogue",
    "emotion": "Emotions",
    "timeline": "Actions on the timelines",
    "attribute": "What holds for the whole clip",
}
MUCH = 2.0  # times as often


@dataclass(frozen=True)
class Bar:
    """name: in words; action: one of ours, whose colour the bar has, or the empty string."""

    name: str
    action: str
    clips: int
    share: float
    title: str


@dataclass(frozen=True)
class Kind:
    """Things of one kind, the commonest first; tail: the rarest, after `hidden` others."""

    heading: str
    bars: list[Bar]
    hidden: int
    tail: list[Bar]

    @property
    def most(self) -> float:
        return self.bars[0].share


@dataclass(frozen=True)
class Shows:
    """reason: why there is nothing to tell. imbalance: a sentence about what is rare, or empty.

    balance: how far rare things are weighted up. weights: the least and the largest of a clip.
    """

    kinds: list[Kind]
    imbalance: str
    balance: float
    weights: tuple[float, float]
    reason: str


def shows(attributes: str | Path, weights: str | Path, balance: float) -> Shows:
    """attributes, weights: tables of these names; balance: how far rare things are weighted up."""
    table = tables.read(tables.ATTRIBUTES, attributes)
    if table.empty:
        why = tables.reason(attributes) or "nothing is known of what the clips show"
        return Shows([], "", balance, (1.0, 1.0), why)
    table = table.sort_values(["clips", "attribute"], ascending=[False, True], kind="stable")
    groups = dict(iter(table.groupby("kind")))
    kinds = [_kind(KINDS[kind], groups[kind]) for kind in KINDS if kind in groups]
    weighted = tables.read(tables.WEIGHTS, weights)["weight"]
    extremes = (weighted.min(), weighted.max()) if len(weighted) else (1.0, 1.0)
    return Shows(kinds, _imbalance(groups), balance, extremes, "")


def _kind(heading: str, rows: pd.DataFrame) -> Kind:
    bars = [_bar(row) for row in rows.itertuples()]
    if len(bars) <= MOST_BARS:
        return Kind(heading, bars, 0, [])
    shown = MOST_BARS - RAREST
    return Kind(heading, bars[:shown], len(bars) - MOST_BARS, bars[-RAREST:])


def _bar(row) -> Bar:
    title = f"{words.clips(row.clips)}, {words.percent(row.share)}"
    if pd.notna(row.seconds):
        title += f", {words.minutes(row.seconds)} minutes"
    action = row.attribute if row.kind == "timeline" and row.attribute in ACTIONS else ""
    return Bar(thing(row.attribute), action, int(row.clips), float(row.share), title)


def thing(name: str) -> str:
    """An attribute in words: lighting:soft_light → lighting: soft light, BrowUp → brow up."""
    if name in ACTIONS:
        return words.spaced(name)
    return name.replace("_", " ").replace(":", ": ")


def _imbalance(groups: Mapping[str, pd.DataFrame]) -> str:
    """How much more often the commonest is shown than the rarest, where it is much."""
    told = []
    for kind in MOVING:
        rows = groups.get(kind)
        if rows is None or len(rows) < 2:
            continue
        most, least = rows.iloc[0], rows.iloc[-1]
        times = most["clips"] / max(least["clips"], 1)
        if times >= MUCH:
            told.append(
                f"{_named(most)} is shown {words.number(times)} times as often as {_named(least)}"
            )
    return f"{words.listing(told)}." if told else ""


def _named(row: pd.Series) -> str:
    return f"“{thing(row['attribute'])}” ({words.clips(row['clips'])})"
