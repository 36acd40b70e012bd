"""Runs: stretches of consecutive frames of one clip, and of one value where one is given."""

import numpy as np
import pandas as pd


def run_starts(frames: pd.DataFrame, value: np.ndarray | None = None) -> np.ndarray:
    """Rows at which a run begins.

    frames: clip_id and frame, sorted by them; a run ends where the clip changes or frames are
    missing. value (n_frames,): it also ends where the value changes.
    """
    clip, frame = frames["clip_id"].to_numpy(), frames["frame"].to_numpy(dtype="int64")
    first = np.ones(len(frames), dtype=bool)
    first[1:] = (clip[1:] != clip[:-1]) | (frame[1:] != frame[:-1] + 1)
    if value is not None:
        first[1:] |= value[1:] != value[:-1]
    return np.flatnonzero(first)
