"""TICC on a region's series: a cluster for every frame of every clip."""

import logging
from pathlib import Path

import numpy as np

from mimeline import tables
from mimeline.annotation.series import sequences
from mimeline.ticc import TICC
from mimeline.vocabulary import series_channels

log = logging.getLogger(__name__)

LEAST_WINDOWS = 10  # per cluster and frame of a window: fewer say nothing of a covariance
STILL = 1e-6  # a channel whose deviation is less never moves


def segment(
    series: Path,
    model: Path,
    clusters: Path,
    region: str,
    side: str,
    n_clusters: int,
    window: int,
    beta: float,
    sparsity: float,
    max_iter: int,
    seed: int,
) -> None:
    """Fit TICC on the series (Ma et al. 2025, 3.1) and label every frame.

    model: folder for the fitted model; with too little data, or a channel that never moves, it
    stays empty and the clusters table tells why. The other keys are TICC's.
    """
    table = tables.read(tables.SERIES[region, side], series)
    frames, lengths = sequences(table)
    channels = list(series_channels(region, side))
    model.mkdir(parents=True, exist_ok=True)
    X = frames[channels].to_numpy("float64")
    reason = tables.reason(series) or _unfit(X, lengths, channels, n_clusters, window)
    if reason:
        log.info("%s is not segmented: %s", region, reason)
        tables.write(tables.CLUSTERS, tables.empty(tables.CLUSTERS), clusters, reason)
        return
    ticc = TICC(n_clusters, window, beta, sparsity, max_iter, seed)
    ticc.fit(X, lengths)
    labels, margins = ticc.decode(X, lengths)
    ticc.save(model)
    rows = frames[["clip_id", "frame"]].assign(cluster=labels, margin=margins)
    tables.write(tables.CLUSTERS, rows, clusters)
    log.info(
        "%s: %d frames in %d clusters after %d iterations, objective %.1f",
        region,
        len(rows),
        n_clusters,
        ticc.n_iter_,
        ticc.objective_,
    )


def _unfit(
    X: np.ndarray, lengths: np.ndarray, channels: list[str], n_clusters: int, window: int
) -> str:
    """Why nothing can be learnt from X (T, n), sequences of lengths (S,); empty where it can."""
    windows = int(np.maximum(lengths - window + 1, 0).sum())
    needed = n_clusters * window * LEAST_WINDOWS
    if windows < needed:
        counted = f"{windows} windows of {window} frames"
        return f"{counted} are too few for {n_clusters} clusters: {needed} are needed"
    still = [name for name, std in zip(channels, X.std(axis=0), strict=True) if std < STILL]
    return f"never moves: {', '.join(still)}" if still else ""
