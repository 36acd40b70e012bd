"""Which intervals of a cluster a person looks at before naming it."""

import numpy as np
import pandas as pd
from scipy.spatial.distance import cdist

from mimeline.annotation.runs import cluster_runs, run_changes, run_means

CANDIDATES = 256  # intervals of a cluster among which the further ones are sought
SHAPE = 0.15  # how much a rise counts beside the mean: names follow from levels
STILL = 1e-6  # a channel that deviates less does not tell intervals apart
COLUMNS = ["cluster", "clip_id", "start_frame", "end_frame", "kind", "rank"]


def choose(
    clusters: pd.DataFrame,
    values: np.ndarray,
    n_random: int,
    n_further: int,
    rng: np.random.Generator,
) -> pd.DataFrame:
    """Exemplars of each cluster, all of them different intervals, in the order to be shown.

    clusters: the `clusters` table; values (n_frames, n_channels): the series at its rows.
    Returns cluster, clip_id, start_frame, end_frame, kind, rank. Each kind is chosen among the
    intervals that those before it left: the medoid, of median length or longer, whose mean lies
    nearest to the cluster's; the longest; the border interval, of the least mean margin to another
    cluster; n_random random ones, an interval as likely as it is long; n_further further ones (see
    `_further`). A cluster of fewer intervals shows them all.
    """
    runs = cluster_runs(clusters)
    if runs.empty:
        return runs.assign(kind="", rank=0)[COLUMNS]
    lengths = (runs["end_frame"] - runs["start_frame"]).to_numpy()
    means = run_means(runs, values)
    unit = np.maximum(values.std(axis=0), STILL)
    shapes = np.concatenate([means, SHAPE * run_changes(runs, values)], axis=1)  # (n_runs, 2n)
    shapes /= np.tile(unit, 2)
    facts = runs.assign(length=lengths, clip=pd.factorize(runs["clip_id"])[0])
    chosen = []
    for _, rows in sorted(runs.groupby("cluster").indices.items()):
        own = facts.iloc[rows]
        picks = _first(own, means[rows] / unit, n_random, rng)
        shown = [pick for pick, _ in picks]
        further = _further(own, shapes[rows], shown, n_further, rng)
        picks += [(pick, "further") for pick in further]
        order, kinds = zip(*picks, strict=True)
        chosen.append(own.iloc[list(order)].assign(kind=kinds, rank=range(len(kinds))))
    return pd.concat(chosen, ignore_index=True)[COLUMNS]


def _first(
    runs: pd.DataFrame, means: np.ndarray, n_random: int, rng: np.random.Generator
) -> list[tuple[int, str]]:
    """Medoid, longest, border and random ones of a cluster's runs, each with its kind."""
    length = runs["length"].to_numpy()
    away = np.square(means - np.average(means, axis=0, weights=length)).sum(axis=1)
    picks = [(_least(away, length >= np.median(length)), "medoid")]
    left = np.ones(len(runs), dtype=bool)
    for kind, order in (("longest", -length), ("border", runs["margin"].to_numpy())):
        left[picks[-1][0]] = False
        if left.any():
            picks.append((_least(order, left), kind))
    left[picks[-1][0]] = False
    some = np.flatnonzero(left)
    if n_random and len(some):
        odds = length[some] / length[some].sum()
        drawn = rng.choice(some, min(n_random, len(some)), replace=False, p=odds)
        picks += [(int(pick), "random") for pick in drawn]
    return picks


def _least(values: np.ndarray, allowed: np.ndarray) -> int:
    among = np.flatnonzero(allowed)
    return int(among[np.argmin(values[among])])


def _further(
    runs: pd.DataFrame,
    shapes: np.ndarray,
    shown: list[int],
    count: int,
    rng: np.random.Generator,
) -> list[int]:
    """At most so many of a cluster's runs: what tells most of what those shown do not tell first.

    shapes (n, d): what intervals are compared by. A frame is as badly known as its interval's shape
    lies far, squared, from the nearest one shown; each pick makes the frames known best. Clips of
    which less was shown go first.
    Source: greedy k-medians; Nemhauser, Wolsey and Fisher 1978 bound what greed loses.
    """
    length, clip = runs["length"].to_numpy(), runs["clip"].to_numpy()
    left, most = np.setdiff1d(np.arange(len(runs)), shown), max(CANDIDATES, count)
    if len(left) > most:
        odds = length[left] / length[left].sum()
        left = np.sort(rng.choice(left, most, replace=False, p=odds))
    unknown = cdist(shapes, shapes[shown], "sqeuclidean").min(axis=1)  # (n,)
    apart = cdist(shapes, shapes[left], "sqeuclidean")  # (n, n_left)
    told = np.bincount(clip[shown], minlength=clip.max() + 1)
    free = np.ones(len(left), dtype=bool)
    picks = []
    for _ in range(min(count, len(left))):
        cost = length @ np.minimum(apart, unknown[:, None])  # (n_left,)
        known = told[clip[left]]
        pick = _least(cost, free & (known == known[free].min()))
        free[pick] = False
        told[clip[left[pick]]] += 1
        unknown = np.minimum(unknown, apart[:, pick])
        picks.append(int(left[pick]))
    return picks
