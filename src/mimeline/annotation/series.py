"""The long series of a facial region: all clips end to end, a null sequence between them."""

import logging
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.annotation.runs import run_starts
from mimeline.vocabulary import DEAD_RANGE, series_channels

log = logging.getLogger(__name__)

SHARE_INSIDE = (0.005, 0.995)  # quantiles between which a range is taken: a glitch is no motion


def series(
    clips: Sequence[Path],
    motions: Sequence[Path],
    series: Path,
    region: str,
    side: str,
    null_length: int,
    null_value: float,
) -> None:
    """Concatenate the region's descriptor channels of every kept clip (Ma et al. 2025, 3.1).

    A clip with masked frames gives one sequence per stretch of valid ones. null_length: frames of
    the separator; null_value: its value in every channel.
    """
    kept = tables.read_all(tables.CLIPS, clips, ["clip_id"])["clip_id"]
    channels = list(series_channels(region, side))
    motion = tables.read_all(tables.MOTION, motions, ["clip_id", "frame", "valid", *channels])
    motion = motion[motion["clip_id"].isin(kept)]
    measured = motion["valid"] & motion[channels].notna().all(axis=1)
    table = concatenate(motion[measured], channels, null_length, null_value)
    reason = ""
    if table.empty:
        reason = why_empty(motion, channels)
    tables.write(tables.SERIES[region, side], table, series, reason)
    log.info("%s series: %s", region, reason or f"{len(sequences(table)[1])} sequences")


def why_empty(motion: pd.DataFrame, channels: list[str]) -> str:
    """Why no frame of motion (valid, channels) is valid and has all channels."""
    if motion.empty:
        return "no clip came through"
    valid = motion.loc[motion["valid"], channels]
    if valid.empty:
        return "no frame is valid"
    absent = [name for name in channels if valid[name].isna().all()]
    if absent:
        return f"not measured: {', '.join(absent)}"
    return f"not measured in one frame: {', '.join(channels)}"


def concatenate(
    frames: pd.DataFrame, channels: list[str], null_length: int, null_value: float
) -> pd.DataFrame:
    """Sequences end to end, with a separator between each two.

    frames: clip_id, frame and the channels, in order; a sequence ends where the clip or the count
    of frames breaks. Returns position, clip_id and frame (null in a separator), channels.
    """
    starts = run_starts(frames)
    number = np.repeat(np.arange(len(starts)), np.diff([*starts, len(frames)]))
    table = frames[["clip_id", "frame", *channels]].assign(
        position=np.arange(len(frames)) + null_length * number
    )
    total = len(table) + null_length * max(len(starts) - 1, 0)
    gaps = np.delete(np.arange(total), table["position"])
    nulls = pd.DataFrame({"position": gaps, **dict.fromkeys(channels, null_value)})
    table = pd.concat([table.astype({"frame": "Int64"}), nulls]) if len(gaps) else table
    return table.sort_values("position", ignore_index=True)


def sequences(table: pd.DataFrame) -> tuple[pd.DataFrame, np.ndarray]:
    """The series without its separators, and the length of each sequence."""
    frames = table[table["clip_id"].notna()]
    starts = run_starts(frames)
    return frames, np.diff([*starts, len(frames)])


def dead_channels(values: pd.DataFrame) -> list[str]:
    """The columns that hardly move: what TICC is fitted without.

    values: a column per channel, a row per frame of a series without its separators.
    """
    low, high = (values.quantile(share) for share in SHARE_INSIDE)
    return list(values.columns[high - low < DEAD_RANGE])
