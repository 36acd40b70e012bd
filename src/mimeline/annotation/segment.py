"""TICC on a region's series: a cluster for every frame of every clip."""

import logging
from pathlib import Path

from mimeline import tables
from mimeline.annotation.region_model import RegionModel
from mimeline.annotation.region_series import RegionSeries
from mimeline.ticc import TICC

log = logging.getLogger(__name__)


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
    empty and the clusters table tells why. null_length, null_value: the series' separators, which
    `boundary: paper` clusters as well. The other keys are TICC's.
    """
    found = RegionSeries.read(series, region, side)
    model.mkdir(parents=True, exist_ok=True)
    if reason := found.refusal(n_clusters, window):
        log.info("%s is not segmented: %s", region, reason)
        tables.write(tables.CLUSTERS, tables.empty(tables.CLUSTERS), clusters, reason)
        return
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
    ticc.fit(found.values(), found.lengths)
    fitted = RegionModel(ticc, found.channels)
    fitted.save(model)
    tables.write(tables.CLUSTERS, fitted.decode(found.frames), clusters)
    log.info("%s: %d frames in %d clusters", region, len(found.frames), n_clusters)
    if not ticc.converged_:
        log.warning("%s: labels still change after max_iter = %d iterations", region, max_iter)
