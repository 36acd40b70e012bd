"""Segmentations of a region over a grid of cluster counts and prices of a switch, each scored."""

import logging
from collections.abc import Mapping, Sequence
from itertools import groupby
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.annotation.annotate import unmeasured_actions
from mimeline.annotation.region_series import RegionSeries
from mimeline.annotation.scores import cluster_votes, macro_f1, true_codes
from mimeline.annotation.timelines import read_truth
from mimeline.progress import told
from mimeline.ticc import TICC
from mimeline.ticc.selection import along_betas, bic, n_switches, stability
from mimeline.vocabulary import SERIES_TRACK

log = logging.getLogger(__name__)


def sweep(
    clips: Sequence[Path],
    ledgers: Sequence[Path],
    series: Path,
    truth: Path | None,
    scores: Path,
    region: str,
    side: str,
    n_clusters: Sequence[int],
    betas: Sequence[float],
    seeds: int,
    null_length: int,
    null_value: float,
    configured: Mapping[str, Any],
) -> None:
    """Write the `sweep` table: a row for each of n_clusters, betas and seeds.

    null_length, null_value: the series' separators. configured: TICC's arguments otherwise. Its own
    n_clusters and beta join the grid, and its seed is the first of the seeds. clips, ledgers:
    tables of all stages before, by which truth is read, of `read_truth`; without it (None) f1 is
    not known.
    Channels that never move are left out, counts of clusters that the frames are too few for are
    not tried; where nothing is left, the table is empty and tells why.
    """
    found, window = RegionSeries.read(series, region, side), configured["window"]
    counts = sorted({*n_clusters, configured["n_clusters"]})
    tried = [count for count in counts if not found.refusal(count, window)]
    if not tried:
        reason = found.refusal(counts[0], window)
        log.info("%s is not swept: %s", region, reason)
        tables.write(tables.SWEEP, tables.empty(tables.SWEEP), scores, reason)
        return
    if len(tried) < len(counts):
        log.warning("%s: too few frames for more than %d clusters", region, tried[-1])
    X, lengths = found.values(), found.lengths
    codes = None
    if truth is not None:
        decisions = tables.read_all(tables.LEDGER, ledgers)
        true = read_truth(truth, tables.read_all(tables.CLIPS, clips), decisions)
        codes = series_truth(found.frames, true, region)
    prices = sorted({*map(float, betas), float(configured["beta"])})
    separators = {"null_length": null_length, "null_value": null_value}
    runs = [(count, configured["seed"] + nth) for count in tried for nth in range(seeds)]
    runs_told, rows = told(runs, f"runs over beta on the {region} series", log), []
    for count, of_count in groupby(runs_told, key=itemgetter(0)):
        begun, labels = len(rows), {beta: [] for beta in prices}
        for _, seed in of_count:
            own = {**configured, **separators, "n_clusters": count, "seed": seed}
            for beta, ticc in _fits(own, prices, X, lengths).items():
                labels[beta].append(_smallest(ticc.labels_))
                rows.append(
                    {
                        "n_clusters": count,
                        "beta": beta,
                        "seed": seed,
                        "objective": ticc.objective_,
                        **facts(X, lengths, ticc.labels_, window),
                        "f1": np.nan if codes is None else best_f1(ticc.labels_, codes, region),
                    }
                )
        agreed = {beta: stability(alike) for beta, alike in labels.items()}
        for row in rows[begun:]:
            row["stability"] = agreed[row["beta"]]
    table = pd.DataFrame(rows).assign(region=region)
    tables.write(tables.SWEEP, table, scores)
    log.info("%s: %d fits", region, len(table))


def _fits(own: Mapping[str, Any], betas: Sequence[float], X, lengths) -> dict[float, TICC]:
    return along_betas(lambda beta: TICC(**own | {"beta": beta}), betas, X, lengths)


def _smallest(labels: np.ndarray) -> np.ndarray:
    """labels (T,) in the smallest unsigned type that holds them: many fits wait for each other."""
    return labels.astype(np.min_scalar_type(labels.max()))


def facts(X, lengths, labels, window: int) -> dict[str, float]:
    """What can be said of labels (T,) of X (T, n) without a truth."""
    switched = n_switches(labels, lengths)
    return {
        "bic": bic(X, lengths, labels, window),
        "n_switches": switched,
        "mean_frames": len(X) / (switched + len(lengths)),
        "used": len(np.unique(labels)),
    }


def series_truth(frames: pd.DataFrame, true: pd.DataFrame, region: str) -> np.ndarray:
    """(n_frames,) the true class of each frame of a series, -1 where it does not count.

    true: a `frames` table.
    """
    both = frames[["clip_id", "frame"]].merge(true, how="left", validate="1:1")
    track = SERIES_TRACK[region]
    return true_codes(both, track, unmeasured_actions(true, track))


def best_f1(labels: np.ndarray, codes: np.ndarray, region: str) -> float:
    """Macro-F1 where each cluster bears the name that most of its frames have in truth.

    labels, codes (n_frames,), codes of -1 do not count. NaN where none counts.
    """
    if not (codes >= 0).any():
        return float("nan")
    votes = cluster_votes(labels, codes, labels.max() + 1, SERIES_TRACK[region])
    confusion = np.zeros((votes.shape[1], votes.shape[1]), dtype="int64")  # truth in rows
    np.add.at(confusion.T, votes.argmax(axis=1), votes)
    return float(macro_f1(confusion))
