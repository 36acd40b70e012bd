"""TICC on a region's series: a cluster for every frame of every clip."""

import logging
from pathlib import Path

import numpy as np

from mimeline import tables
from mimeline.annotation.region_model import RegionModel
from mimeline.annotation.series import dead_channels, sequences
from mimeline.ticc import TICC
from mimeline.vocabulary import series_channels

log = logging.getLogger(__name__)

LEAST_WINDOWS = 10  # per cluster and frame of a window: fewer say nothing of a covariance


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
    boundary: str,
    null_length: int,
    null_value: float,
    max_iter: int,
    seed: int,
) -> None:
    """Fit TICC on the series (Ma et al. 2025, 3.1) and label every frame.

    model: folder for the fitted model; with too little data, or where no channel moves, it stays
    empty and the clusters table tells why. Channels that the tracker does not move are left out:
    brought to unit variance, their jitter would weigh as much as motion. null_length, null_value:
    the series' separators, which `boundary: paper` clusters as well. The other keys are TICC's.
    """
    frames, lengths = sequences(tables.read(tables.SERIES[region, side], series))
    measured = list(series_channels(region, side))
    dead = dead_channels(frames[measured])
    channels = [name for name in measured if name not in dead]
    model.mkdir(parents=True, exist_ok=True)
    windows = int(np.maximum(lengths - window + 1, 0).sum())
    needed = n_clusters * window * LEAST_WINDOWS
    reason = tables.reason(series)
    if not reason and windows < needed:
        counted = f"{windows} windows of {window} frames"
        reason = f"{counted} are too few for {n_clusters} clusters: {needed} are needed"
    if not reason and not channels:
        reason = f"never moves: {', '.join(dead)}"
    if reason:
        log.info("%s is not segmented: %s", region, reason)
        tables.write(tables.CLUSTERS, tables.empty(tables.CLUSTERS), clusters, reason)
        return
    if dead:
        log.warning("%s: left out, since it never moves: %s", region, ", ".join(dead))
    ticc = TICC(
        n_clusters,
        window,
        beta,
        sparsity,
        boundary=boundary,
        null_length=null_length,
        null_value=null_value,
        max_iter=max_iter,
        seed=seed,
    )
    ticc.fit(frames[channels].to_numpy("float64"), lengths)
    fitted = RegionModel(ticc, tuple(channels))
    fitted.save(model)
    tables.write(tables.CLUSTERS, fitted.decode(frames), clusters)
    log.info("%s: %d frames in %d clusters", region, len(frames), n_clusters)
    if not ticc.converged_:
        log.warning("%s: labels still change after max_iter = %d iterations", region, max_iter)
