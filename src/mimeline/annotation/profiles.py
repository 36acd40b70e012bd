"""A cluster's facts: how large and how pure it is, and which other cluster lies how near."""

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.annotation.proposals import Rules
from mimeline.annotation.region_model import RegionModel
from mimeline.annotation.runs import cluster_runs, run_changes, run_means
from mimeline.annotation.series import sequences

PIECE = 15  # frames: of longer stretches, the mean hides that a cluster holds two actions


def profiles(
    region: str, clusters: pd.DataFrame, values: np.ndarray, model: RegionModel, rules: Rules
) -> pd.DataFrame:
    """The `profiles` rows of a region.

    clusters: the `clusters` table; values (n_frames, d): the model's channels at its rows.
    purity is estimated: the intervals are cut into pieces of PIECE frames at most, the proposals'
    rule names each piece alone, and counted are the frames in pieces of the commonest name. It is
    null where that is no name, or where no action is measured.
    nearest is the cluster that would take over the frames, were there not their own. distance says
    how much worse it explains them: e to the distance is how many times less likely it makes a
    frame and its neighbours, so that two clusters below 1 apart may well be one thing, while from 5
    on nobody takes one for the other.
    """
    runs = cluster_runs(clusters)
    lengths = runs["end_frame"] - runs["start_frame"]
    present = np.unique(runs["cluster"])
    costs = model.ticc.mean_costs(values, clusters["cluster"].to_numpy(), sequences(clusters)[1])
    extra = costs - np.diag(costs)[:, None]  # (K, K)
    np.fill_diagonal(extra, np.inf)
    extra = extra[np.ix_(present, present)]
    alone = len(present) == 1
    rows = pd.DataFrame({"region": region, "cluster": present}).assign(
        n_frames=lengths.groupby(runs["cluster"]).sum().to_numpy(),
        n_intervals=lengths.groupby(runs["cluster"]).size().to_numpy(),
        n_clips=runs.groupby("cluster")["clip_id"].nunique().to_numpy(),
        median_frames=lengths.groupby(runs["cluster"]).median().to_numpy("float64"),
        purity=_purity(region, runs, values, model.channels, rules),
        nearest=pd.NA if alone else present[extra.argmin(axis=1)],
        distance=np.nan if alone else extra.min(axis=1),
    )
    return rows[tables.PROFILES.schema.names]


def _purity(region, runs: pd.DataFrame, values, channels, rules: Rules) -> np.ndarray:
    """(n_clusters,), NaN where the commonest name is none."""
    pieces = _pieces(runs)
    lengths = (pieces["end_frame"] - pieces["start_frame"]).to_numpy()
    rest = rules.rest(run_means(runs, values), runs["end_frame"] - runs["start_frame"])
    names = rules.names(region, channels)
    means, changes = run_means(pieces, values), run_changes(pieces, values)
    codes = rules.codes(region, channels, means - rest, changes)
    _, cluster = np.unique(pieces["cluster"], return_inverse=True)
    votes = np.bincount(cluster * len(names) + codes, lengths, (cluster.max() + 1) * len(names))
    votes = votes.reshape(-1, len(names))
    told = (votes.argmax(axis=1) < names.index(None)) & (len(names) > 2)
    return np.where(told, votes.max(axis=1) / votes.sum(axis=1), np.nan)


def _pieces(runs: pd.DataFrame) -> pd.DataFrame:
    """Runs cut into equal pieces of PIECE frames at most, in order."""
    lengths = (runs["end_frame"] - runs["start_frame"]).to_numpy()
    counts = -(-lengths // PIECE)
    run = np.repeat(np.arange(len(runs)), counts)
    piece = np.arange(len(run)) - (np.cumsum(counts) - counts)[run]  # of its run
    start = runs["start_frame"].to_numpy()[run]
    first, stop = (lengths[run] * (piece + i) // counts[run] for i in (0, 1))
    cut = {"start_frame": start + first, "end_frame": start + stop}
    return runs.iloc[run].reset_index(drop=True).assign(**cut)
