"""A region's series as TICC is given it: its frames, its channels that move, or why none."""

import logging
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.annotation.series import dead_channels, sequences
from mimeline.vocabulary import series_channels

log = logging.getLogger(__name__)

LEAST_WINDOWS = 10  # per cluster and frame of a window: fewer say nothing of a covariance


@dataclass(frozen=True)
class RegionSeries:
    """A series without its separators.

    frames: clip_id, frame and the region's channels · lengths (S,): frames of each sequence ·
    channels: those that move; brought to unit variance, the jitter of the others would weigh as
    much as motion · reason: why there is nothing to cluster, or the empty string.
    """

    frames: pd.DataFrame
    lengths: np.ndarray
    channels: tuple[str, ...]
    reason: str

    @classmethod
    def read(cls, series: Path, region: str, side: str) -> "RegionSeries":
        """The `series` table of a region; what is left out of it is logged."""
        frames, lengths = sequences(tables.read(tables.SERIES[region, side], series))
        measured = series_channels(region, side)
        dead = dead_channels(frames[list(measured)])
        channels = tuple(name for name in measured if name not in dead)
        reason = tables.reason(series)
        if not reason and not channels:
            reason = f"never moves: {', '.join(dead)}"
        if not reason and dead:
            log.warning("%s: left out, since it never moves: %s", region, ", ".join(dead))
        return cls(frames, lengths, channels, reason)

    def values(self) -> np.ndarray:
        """(T, n) float64: the channels that move."""
        return self.frames[list(self.channels)].to_numpy("float64")

    def refusal(self, n_clusters: int, window: int) -> str:
        """Why it cannot be told apart into so many clusters, or the empty string."""
        windows = int(np.maximum(self.lengths - window + 1, 0).sum())
        needed = n_clusters * window * LEAST_WINDOWS
        if self.reason or windows >= needed:
            return self.reason
        counted = f"{windows} windows of {window} frames"
        return f"{counted} are too few for {n_clusters} clusters: {needed} are needed"
