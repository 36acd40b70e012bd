"""How a face is divided among the branches of the timeline model, and what each of them is told."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from mimeline.vocabulary import ACTIONS, CHANNELS, CONTROL_REGIONS, OUTPUT_GROUPS

Division = Literal["halves", "regions"]

# What each output group sees of the timeline (Ma et al. 2025, section 3.2): the head moves along
# with everything, so the rest sees all.
GROUP_SEES: dict[str, tuple[str, ...]] = {
    "upper": ("brow", "eye", "gaze"),
    "lower": ("mouth",),
    "rest": CONTROL_REGIONS,
}
assert set(GROUP_SEES) == set(OUTPUT_GROUPS)

# All decoupled (Ma et al. 2025, Table 2): a branch per control region, by the start of a channel's
# name; cheeks and nose belong to none and see all.
REGION_CHANNELS: dict[str, tuple[str, ...]] = {
    "brow": ("brow",),
    "gaze": ("gaze", "eyeLook"),
    "eye": ("eye",),
    "mouth": ("mouth", "jaw", "tongue"),
    "head": ("head",),
    "rest": ("cheek", "nose"),
}
REGION_SEES = {r: (r,) if r in CONTROL_REGIONS else CONTROL_REGIONS for r in REGION_CHANNELS}


@dataclass(frozen=True)
class Part:
    """A branch's share: its columns of the motion, and its actions' columns of the timeline."""

    columns: list[int]
    actions: list[int]


def parts(channels: Sequence[str], division: Division) -> dict[str, Part]:
    """The parts of a face that has some of these channels, by name.

    halves: upper and lower face, and the rest (Ma et al. 2025, section 3.2). regions: brow, eyes,
    gaze, mouth, head, and the rest.
    """
    if division == "halves":
        sees, part_of = GROUP_SEES, {c: CHANNELS[c].output_group for c in channels}
    else:
        sees, part_of = REGION_SEES, {c: _region(c) for c in channels}
    return {
        name: Part(columns, _actions(regions))
        for name, regions in sees.items()
        if (columns := [i for i, channel in enumerate(channels) if part_of[channel] == name])
    }


def whole(channels: Sequence[str]) -> dict[str, Part]:
    """All of the face as one part, which sees the timelines of all regions."""
    return {"face": Part(list(range(len(channels))), _actions(CONTROL_REGIONS))}


def _region(channel: str) -> str:
    return next(r for r, starts in REGION_CHANNELS.items() if channel.startswith(starts))


def _actions(regions: Sequence[str]) -> list[int]:
    return [i for i, action in enumerate(ACTIONS.values()) if action.control_region in regions]
