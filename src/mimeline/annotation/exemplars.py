"""A few intervals per cluster for a person to look at, and the name that a rule proposes."""

import logging
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.annotation.fits import remember
from mimeline.annotation.fitted import read_fingerprint
from mimeline.annotation.proposals import propose, read_proposals
from mimeline.annotation.runs import cluster_runs
from mimeline.annotation.series import sequences
from mimeline.vocabulary import series_channels

log = logging.getLogger(__name__)


def exemplars(
    series: dict[str, Path],
    clusters: dict[str, Path],
    models: dict[str, Path],
    rules: Path,
    proposed: Path,
    exemplars: Path,
    profiles: Path,
    side: str,
    n_random: int,
    n_further: int,
    seed: int,
) -> None:
    """Propose a name for every cluster and choose what a person looks at before naming it.

    series, clusters, models: by region. rules: of the proposals. proposed: a `labels` table to
    write; exemplars, profiles: tables to write.
    """
    limits, fits = read_proposals(rules), Path(exemplars).with_name("fits")
    rows, shown, described = [], [], []
    for number, region in enumerate(series):
        assigned = tables.read(tables.CLUSTERS, clusters[region])
        if assigned.empty:
            continue
        frames, _ = sequences(tables.read(tables.SERIES[region, side], series[region]))
        values = frames[list(series_channels(region, side))].to_numpy("float64")
        assigned = assigned.merge(frames[["clip_id", "frame"]], how="right")  # in series order
        ids = assigned["cluster"].to_numpy("int64")
        proposals = propose(region, values, ids, limits)
        counts = np.bincount(ids)
        for cluster, action in proposals.items():
            share = counts[cluster] / len(ids)
            rows.append((region, cluster, action, None, "proposed", share, None, None, []))
            described.append((region, cluster, counts[cluster], 1, 1, 1.0, None, None, None))
        remember(fits, region, read_fingerprint(models[region]), assigned)
        rng = np.random.default_rng([seed, number])  # one region's refit keeps the others' choice
        shown.append(choose(assigned, values, n_random, rng).assign(region=region))
        log.info("%s: names proposed for %d clusters", region, len(proposals))

    reason = "" if rows else "no region could be segmented"
    table = pd.DataFrame(rows, columns=tables.LABELS.schema.names)
    tables.write(tables.LABELS, table, proposed, reason)
    chosen = pd.concat(shown) if shown else tables.empty(tables.EXEMPLARS)
    tables.write(tables.EXEMPLARS, chosen, exemplars, reason)
    about = pd.DataFrame(described, columns=tables.PROFILES.schema.names)
    tables.write(tables.PROFILES, about, profiles, reason)


def choose(
    clusters: pd.DataFrame, values: np.ndarray, n_random: int, rng: np.random.Generator
) -> pd.DataFrame:
    """Exemplars of each cluster: the medoid, the longest, the most borderline and random intervals.

    clusters: the `clusters` table; values (n_frames, n_channels): the series at its rows.
    Returns cluster, clip_id, start_frame, end_frame, kind. The medoid is the interval, among those
    of median length or longer, whose mean lies nearest to the cluster's; the border interval has
    the least mean margin to another cluster.
    """
    runs = cluster_runs(clusters)
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
    found = pd.concat(chosen)
    found["rank"] = found.groupby("cluster").cumcount()
    return found[["cluster", "clip_id", "start_frame", "end_frame", "kind", "rank"]]
