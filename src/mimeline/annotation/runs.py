"""Runs: stretches of consecutive frames of one clip, of one value where one is given."""

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


def cluster_runs(clusters: pd.DataFrame) -> pd.DataFrame:
    """Runs of one cluster.

    clusters: the `clusters` table. Returns clip_id, cluster, start_frame, end_frame (half-open) and
    margin (the mean over the run).
    """
    cluster = clusters["cluster"].to_numpy()
    starts = run_starts(clusters, cluster)
    lengths = np.diff([*starts, len(clusters)])
    run = np.repeat(np.arange(len(starts)), lengths)
    frame = clusters["frame"].to_numpy()[starts]
    return pd.DataFrame(
        {
            "clip_id": clusters["clip_id"].to_numpy()[starts],
            "cluster": cluster[starts],
            "start_frame": frame,
            "end_frame": frame + lengths,
            "margin": np.bincount(run, clusters["margin"], minlength=len(starts)) / lengths,
        }
    )


def run_means(runs: pd.DataFrame, values: np.ndarray) -> np.ndarray:
    """(n_runs, d): the mean of each run of `cluster_runs` over values (n_frames, d), its frames."""
    lengths = (runs["end_frame"] - runs["start_frame"]).to_numpy()
    if not len(lengths):
        return np.empty((0, values.shape[1]))
    return np.add.reduceat(values, np.cumsum(lengths) - lengths, axis=0) / lengths[:, None]


def run_changes(runs: pd.DataFrame, values: np.ndarray) -> np.ndarray:
    """(n_runs, d): how far the line through each run's frames rises from its first to its last.

    runs, values: as for run_means.
    """
    lengths = (runs["end_frame"] - runs["start_frame"]).to_numpy()
    starts = np.cumsum(lengths) - lengths
    middle = np.repeat((lengths - 1) / 2, lengths)
    time = np.arange(len(values)) - np.repeat(starts, lengths) - middle  # (n_frames,), mean 0
    slope = run_means(runs, time[:, None] * values)
    variance = np.where(lengths > 1, (lengths**2 - 1) / 12, 1.0)  # of time within each run
    return slope / variance[:, None] * (lengths - 1)[:, None]
