"""TICC on a region's series: a cluster for every frame of every clip."""

import logging
from pathlib import Path

from mimeline import tables
from mimeline.annotation.series import sequences
from mimeline.ticc import TICC
from mimeline.vocabulary import series_channels

log = logging.getLogger(__name__)

LEAST_FRAMES_PER_CLUSTER = 10  # of the window's size: fewer say nothing of a covariance


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

    model: folder for the fitted model; with too little data it stays empty and the clusters table
    tells why. The other keys are TICC's.
    """
    table = tables.read(tables.SERIES[region, side], series)
    frames, lengths = sequences(table)
    channels = list(series_channels(region, side))
    model.mkdir(parents=True, exist_ok=True)
    reason = tables.reason(series)
    needed = n_clusters * window * LEAST_FRAMES_PER_CLUSTER
    if not reason and len(frames) < needed:
        reason = f"{len(frames)} frames are too few for {n_clusters} clusters: {needed} are needed"
    if reason:
        log.info("%s is not segmented: %s", region, reason)
        tables.write(tables.CLUSTERS, tables.empty(tables.CLUSTERS), clusters, reason)
        return
    ticc = TICC(n_clusters, window, beta, sparsity, max_iter, seed)
    X = frames[channels].to_numpy("float64")
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
