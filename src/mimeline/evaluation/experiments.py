"""The experiments of Ma et al. 2025, 4.1, on one region."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from mimeline import tables


def experiments(
    clips: Sequence[Path],
    motions: Sequence[Path],
    units: Sequence[Path],
    origins: Sequence[Path],
    rules: Path,
    descriptors: Path,
    truth: Path | None,
    found: Path,
    region: str,
    side: str,
    n_clusters: Sequence[int],
    betas: Sequence[float],
    null_length: int,
    null_value: float,
    gmm_components: int,
    configured: Mapping[str, Any],
    seeds: int,
    unseen: float,
    claspy: str | None,
) -> None:
    """Write the `experiments` table of a region."""
    tables.write(tables.EXPERIMENTS, tables.empty(tables.EXPERIMENTS), found, "nothing was tried")
