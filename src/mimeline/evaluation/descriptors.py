"""What else than one side's coefficients may describe a region: both sides, or action units.

motion: the table's clip_id, frame, valid and channels of the clips that were kept. Every descriptor
comes as a `RegionSeries`, of the valid frames in which all of it was measured.
"""

from dataclasses import replace

import numpy as np
import pandas as pd
from scipy.ndimage import maximum_filter1d

from mimeline.annotation.region_series import RegionSeries
from mimeline.annotation.runs import run_starts
from mimeline.annotation.series import dead_channels, why_empty
from mimeline.tracking.formats.action_units import ACTION_UNITS, STRONGEST
from mimeline.vocabulary import series_channels

# The units that move what a region's channels do. Closing (AU45) is a track of its own.
UNITS: dict[str, tuple[str, ...]] = {
    "brow": ("AU01", "AU02", "AU04"),
    "eye": ("AU05", "AU07"),
    "mouth": ("AU12", "AU15", "AU20"),
}
# Cafe-Talk gives its rule no numbers.
ACTIVE = 0.4  # coefficient from which a unit is active: Ma et al.'s for a closed eye
KERNELS = (1, 3, 5)  # frames, sizes of the pooling
SPACING, CHANCE = 5, 0.5  # gaps of fewer frames are closed by this chance


def one_side(motion: pd.DataFrame, region: str, side: str) -> RegionSeries:
    """The channels of one side: the paper's descriptor (Ma et al. 2025, 3.1)."""
    return _series(motion, list(series_channels(region, side)))


def both_sides(motion: pd.DataFrame, region: str) -> RegionSeries:
    """The channels of both sides; one that has no side is there once."""
    sided = (name for side in ("left", "right") for name in series_channels(region, side))
    return _series(motion, list(dict.fromkeys(sided)))


def measured_units(units: pd.DataFrame, motion: pd.DataFrame, region: str) -> RegionSeries:
    """The intensities of the region's units that the tracker itself measured, from 0 to 1.

    units: the table `action_units` (0 to 5) of the same clips.
    """
    columns = {f"{unit}_r": unit for unit in UNITS[region]}
    measured = units[["clip_id", "frame", *columns]].rename(columns=columns)
    own = motion[["clip_id", "frame", "valid"]].merge(measured, how="left", on=["clip_id", "frame"])
    own[list(columns.values())] /= STRONGEST
    return _series(own, list(columns.values()))


def ruled_units(motion: pd.DataFrame, region: str, seed: int = 0) -> RegionSeries:
    """The region's units as active (1) or not (0), by rule from the coefficients of both sides.

    The rule of Chen et al. 2025 (Cafe-Talk, C.2, Algorithm 1): a unit is active where its
    coefficient passes a threshold; its intervals grow by a max pooling of random size, here one
    size for a sequence; short gaps are closed at random. The coefficient of a unit with two sides
    is their mean. A unit that is hardly ever active or inactive is left out.
    """
    own = [unit for unit in ACTION_UNITS if unit.unit in UNITS[region]]
    series = _series(motion, [name for unit in own for name in unit.channels])
    rng = np.random.default_rng(seed)
    units = series.frames[["clip_id", "frame"]].copy()
    borders = np.cumsum(series.lengths)[:-1]
    for unit in own:
        past = (series.frames[list(unit.channels)].mean(axis=1) >= ACTIVE).to_numpy()
        active = [_joined(_pooled(part, rng), rng) for part in np.split(past, borders)]
        units[unit.unit] = np.concatenate(active).astype("float64")
    if series.reason:
        return replace(series, frames=units, channels=())
    return _series(units.assign(valid=True), [unit.unit for unit in own])


def _series(measured: pd.DataFrame, columns: list[str]) -> RegionSeries:
    """measured: clip_id, frame, valid and the columns."""
    whole = measured["valid"] & measured[columns].notna().all(axis=1)
    frames = measured.loc[whole, ["clip_id", "frame", *columns]].reset_index(drop=True)
    lengths = np.diff([*run_starts(frames), len(frames)])
    dead = dead_channels(frames[columns])
    moving = tuple(name for name in columns if name not in dead)
    reason = "" if len(frames) else why_empty(measured, columns)
    if not reason and not moving:
        reason = f"never moves: {', '.join(columns)}"
    return RegionSeries(frames, lengths, moving, reason)


def _pooled(active: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """(n,) bool: where a frame of active (n,) is within half a kernel of a drawn size."""
    return maximum_filter1d(active, int(rng.choice(KERNELS)), mode="nearest")


def _joined(active: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """(n,) bool: active (n,) with each gap of fewer than SPACING frames closed, by CHANCE."""
    step = np.diff(active.astype("int8"))
    ends, begins = np.flatnonzero(step < 0) + 1, np.flatnonzero(step > 0) + 1
    begins = begins[begins > ends[0]] if len(ends) else begins[:0]  # a gap lies between two
    joined = active.copy()
    for end, begin in zip(ends, begins, strict=False):
        if begin - end < SPACING and rng.random() < CHANCE:
            joined[end:begin] = True
    return joined
