"""A few intervals per cluster for a person to look at before naming it."""

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.annotation.runs import run_starts


def intervals_of(clusters: pd.DataFrame) -> pd.DataFrame:
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


def choose(
    clusters: pd.DataFrame, values: np.ndarray, n_random: int, rng: np.random.Generator
) -> pd.DataFrame:
    """Exemplars of each cluster: the medoid, the longest, the most borderline and random intervals.

    clusters: the `clusters` table; values (n_frames, n_channels): the series at its rows.
    Returns cluster, clip_id, start_frame, end_frame, kind. The medoid is the interval, among those
    of median length or longer, whose mean lies nearest to the cluster's; the border interval has
    the least mean margin to another cluster.
    """
    runs = intervals_of(clusters)
    if runs.empty:
        return runs.assign(kind="")[["cluster", "clip_id", "start_frame", "end_frame", "kind"]]
    lengths = (runs["end_frame"] - runs["start_frame"]).to_numpy()
    sums = np.add.reduceat(values, np.concatenate([[0], np.cumsum(lengths)[:-1]]), axis=0)
    means = sums / lengths[:, None]  # (n_runs, n_channels)
    chosen = []
    for cluster, group in runs.groupby("cluster"):
        rows = group.index.to_numpy()
        centre = sums[rows].sum(axis=0) / lengths[rows].sum()
        typical = rows[lengths[rows] >= np.median(lengths[rows])]
        medoid = typical[np.argmin(np.square(means[typical] - centre).sum(axis=1))]
        picks = {
            "medoid": [medoid],
            "longest": [rows[np.argmax(lengths[rows])]],
            "border": [rows[np.argmin(group["margin"].to_numpy())]],
            "random": rng.choice(rows, min(n_random, len(rows)), replace=False),
        }
        for kind, picked in picks.items():
            chosen.append(runs.loc[picked].assign(cluster=cluster, kind=kind))
    return pd.concat(chosen)[["cluster", "clip_id", "start_frame", "end_frame", "kind"]]


def table(region: str, chosen: pd.DataFrame) -> pd.DataFrame:
    """The exemplars of a region in the columns of the `exemplars` table."""
    return chosen.assign(region=region)[tables.EXEMPLARS.schema.names]
