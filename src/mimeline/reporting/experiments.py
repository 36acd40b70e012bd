"""The page of the experiments, beside the paper's numbers."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from mimeline import tables


def experiments(
    found: Mapping[str, Path],
    annotation: Path,
    paper: Path,
    page: Path,
    summary: Path,
    n_clusters: Sequence[int],
    beta: Sequence[float],
    claspy: str | None,
    resamples: int,
    seed: int,
    address: str,
) -> None:
    """Write the page and its numbers."""
    Path(page).write_text("<!doctype html><title>Experiments</title>", encoding="utf-8")
    tables.write(tables.METRICS, tables.empty(tables.METRICS), summary, "nothing was tried")
