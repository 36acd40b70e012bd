"""What the source measures: each channel's range, or that it is flat or absent."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.vocabulary import CHANNELS, DEAD_RANGE

ANGLE_DEG = 45.0  # half of the range that angles are drawn in
_REGIONS = ("brow", "eye", "cheek", "nose", "jaw", "mouth", "tongue", "gaze", "head")
_SIDES = ("Left", "Right")


@dataclass(frozen=True)
class Bar:
    """A channel's range within its picture, as shares of the width.

    state: measured, dead or absent. start, stop, mean in [0, 1]; text: what a person reads.
    """

    side: str
    state: str
    start: float
    stop: float
    mean: float
    text: str


@dataclass(frozen=True)
class Cell:
    """A channel, or the two of a left and a right."""

    name: str
    angle: bool
    bars: list[Bar]


@dataclass(frozen=True)
class Mapped:
    """A channel that was had through a face model, and what that kept of it, in [0, 1]."""

    name: str
    origin: str
    quality: float


@dataclass(frozen=True)
class Channels:
    """regions: name → cells; dead, absent: names of channels; reason: why nothing is known.

    why_absent: what keeps channels from being measured → their names. mapped: the channels that a
    face model gave, least quality first.
    """

    regions: dict[str, list[Cell]]
    measured: int
    dead: list[str]
    absent: list[str]
    reason: str
    why_absent: dict[str, list[str]] = field(default_factory=dict)
    mapped: list[Mapped] = field(default_factory=list)


def channels(statistics: str | Path, origins: Sequence[str | Path]) -> Channels:
    """Read the `statistics` table (over the training part's valid frames).

    origins: `origins` tables, of each shard.
    """
    rows = tables.read(tables.STATISTICS, statistics)
    if rows.empty or not (rows["measured"] > 0).any():
        reason = tables.reason(statistics) or "no clip came through, so nothing was measured"
        return Channels({}, 0, [], rows["channel"].tolist(), reason)
    rows = rows.set_index("channel")
    had = tables.read_all(tables.ORIGINS, origins)
    states = {name: _state(row) for name, row in rows.iterrows()}
    regions: dict[str, dict[str, list[Bar]]] = {region: {} for region in _REGIONS}
    for name in rows.index:
        base, side = _split_side(name)
        region = next(r for r in _REGIONS if name.lower().startswith(r))
        regions[region].setdefault(base, []).append(_bar(rows.loc[name], name, side, states[name]))
    return Channels(
        regions={
            region: [Cell(base, _is_angle(base), bars) for base, bars in cells.items()]
            for region, cells in regions.items()
            if cells
        },
        measured=sum(state != "absent" for state in states.values()),
        dead=[name for name, state in states.items() if state == "dead"],
        absent=[name for name, state in states.items() if state == "absent"],
        reason="",
        why_absent=_why_absent(had),
        mapped=_mapped(had),
    )


def _why_absent(origins: pd.DataFrame) -> dict[str, list[str]]:
    """Reason → the channels that no shard's results measure for it."""
    given = set(origins.loc[origins["measured"], "channel"])
    lacking = origins[~origins["channel"].isin(given)].drop_duplicates("channel")
    groups = lacking.groupby("origin", sort=False)["channel"]
    return {str(reason): names.tolist() for reason, names in groups}


def _mapped(origins: pd.DataFrame) -> list[Mapped]:
    """The channels with a quality, at the least that a shard's results give."""
    known = origins[origins["measured"] & origins["quality"].notna()]
    known = known.sort_values("quality", kind="stable").drop_duplicates("channel")
    return [Mapped(row.channel, row.origin, float(row.quality)) for row in known.itertuples()]


def _is_angle(base: str) -> bool:
    return base in CHANNELS and CHANNELS[base].unit == "rad"


def _split_side(name: str) -> tuple[str, str]:
    for side in _SIDES:
        base = name.removesuffix(side)
        both = base != name and all(base + other in CHANNELS for other in _SIDES)
        if both and base not in ("jaw", "mouth"):  # jawLeft and jawRight are directions, not sides
            return base, side
    return name, ""


def _state(row: pd.Series) -> str:
    if not row["measured"] > 0:
        return "absent"
    return "dead" if row["high"] - row["low"] < DEAD_RANGE else "measured"


def _bar(row: pd.Series, name: str, side: str, state: str) -> Bar:
    if state == "absent":
        return Bar(side, state, 0, 0, 0, f"{name}: not measured")
    low, high, mean = float(row["low"]), float(row["high"]), float(row["mean"])
    if CHANNELS[name].unit == "rad":
        low, high, mean = (float(np.degrees(v)) for v in (low, high, mean))
        shares = [(v + ANGLE_DEG) / (2 * ANGLE_DEG) for v in (low, high, mean)]
        text = f"{name}: {low:.0f}° to {high:.0f}°, mean {mean:.1f}°"
    else:
        shares = [low, high, mean]
        text = f"{name}: {low:.2f} to {high:.2f}, mean {mean:.2f}"
    if row["measured"] < 1:
        text += f", in {100 * row['measured']:.0f} % of frames"
    if state == "dead":
        text += "; hardly moves"
    start, stop, at = (round(float(np.clip(s, 0, 1)), 3) for s in shares)
    return Bar(side, state, start, stop, at, text)
