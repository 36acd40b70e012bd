"""Channels, regions, tracks and actions: the words of the field, read from the resource tables.

Left and right are the subject's. Channels are known by name, never by position.
"""

import csv
from dataclasses import dataclass
from pathlib import Path

PACKAGE = Path(__file__).parent
CHECKOUT = PACKAGE.parents[1]


def resource(name: str) -> Path:
    """Path of a small static table: inside an installed package, else in the checkout."""
    packed = PACKAGE / "resources" / name
    return packed if packed.exists() else CHECKOUT / "resources" / name


def _rows(name: str) -> list[dict[str, str]]:
    with open(resource(name), encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


@dataclass(frozen=True)
class Channel:
    """A number per frame. `mirror` and `mirror_sign` say what a mirrored picture makes of it."""

    name: str
    kind: str  # expression, head or gaze
    unit: str  # "1" for a coefficient of [0, 1], "rad" for an angle
    mirror: str
    mirror_sign: int
    output_group: str  # upper, lower or rest: the branch that generates it


@dataclass(frozen=True)
class Action:
    """One of the 16 facial actions of Ma et al. 2025, Table 1."""

    name: str
    control_region: str  # brow, eye, mouth, gaze or head: what a condition is dropped by
    track: str  # intervals of one track exclude each other


CHANNELS: dict[str, Channel] = {
    row["channel"]: Channel(
        row["channel"],
        row["kind"],
        row["unit"],
        row["mirror"],
        int(row["mirror_sign"]),
        row["output_group"],
    )
    for row in _rows("channels.csv")
}
EXPRESSIONS: tuple[str, ...] = tuple(c.name for c in CHANNELS.values() if c.kind == "expression")
HEAD: tuple[str, ...] = tuple(c.name for c in CHANNELS.values() if c.kind == "head")
GAZE: tuple[str, ...] = tuple(c.name for c in CHANNELS.values() if c.kind == "gaze")
OUTPUT_GROUPS: tuple[str, ...] = tuple(dict.fromkeys(c.output_group for c in CHANNELS.values()))

ACTIONS: dict[str, Action] = {
    row["action"]: Action(row["action"], row["control_region"], row["track"])
    for row in _rows("actions.csv")
}
NEUTRAL = "Neutral"  # the absence of every action of a track
TRACKS: tuple[str, ...] = tuple(dict.fromkeys(a.track for a in ACTIONS.values()))
CONTROL_REGIONS: tuple[str, ...] = tuple(dict.fromkeys(a.control_region for a in ACTIONS.values()))

SERIES_REGIONS: tuple[str, ...] = tuple(dict.fromkeys(r["region"] for r in _rows("regions.csv")))
SERIES_TRACK: dict[str, str] = {r["region"]: r["track"] for r in _rows("regions.csv")}
DESCRIPTORS: dict[str, tuple[str, ...]] = {
    region: tuple(r["descriptor"] for r in _rows("regions.csv") if r["region"] == region)
    for region in SERIES_REGIONS
}


# What else than channels a tracking result may hold, each a table beside `motion`.
REPRESENTATIONS: tuple[str, ...] = ("flame", "bfm", "action_units", "landmarks")

UNKNOWN = -1.0  # an action's value in a timeline where it was not measured or is not told

# A channel whose range over all frames is less is not moved by its tracker: what is left is jitter.
DEAD_RANGE = 0.02  # of a coefficient; of an angle in radians


def track_actions(track: str) -> tuple[str, ...]:
    """The actions that exclude each other on a track, in Table 1 order."""
    return tuple(a.name for a in ACTIONS.values() if a.track == track)


def region_actions(control_region: str) -> tuple[str, ...]:
    """The actions that a control region holds, in Table 1 order."""
    return tuple(a.name for a in ACTIONS.values() if a.control_region == control_region)


def series_actions(region: str) -> tuple[str, ...]:
    """The actions that the clusters of a series region may be named after."""
    return track_actions(SERIES_TRACK[region])


def series_channels(region: str, side: str) -> tuple[str, ...]:
    """The channels of a series region on one side ("left" or "right") of the face."""
    sided = (descriptor + side.capitalize() for descriptor in DESCRIPTORS[region])
    return tuple(
        name if name in CHANNELS else descriptor
        for name, descriptor in zip(sided, DESCRIPTORS[region], strict=True)
    )


_BY_FOLDED = {name.casefold(): name for name in CHANNELS}


def canonical(name: str) -> str | None:
    """The channel that a file's column name means, or None: any case, `_L`/`_R` for Left/Right."""
    folded = name.strip().casefold()
    for suffix, side in (("_l", "left"), ("_r", "right")):
        if folded.endswith(suffix):
            folded = folded.removesuffix(suffix) + side
    return _BY_FOLDED.get(folded)
