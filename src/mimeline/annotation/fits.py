"""The clusters of every fit that names may belong to, kept beside the results: names move by them.

They are no output of a rule: a refit must not delete what the names of the fit before are moved by.
"""

from pathlib import Path

import pandas as pd

from mimeline import tables
from mimeline.annotation.runs import cluster_runs


def remember(folder: Path, region: str, fingerprint: str, clusters: pd.DataFrame) -> None:
    """Keep a fit's clusters. clusters: the `clusters` table."""
    columns = tables.SEGMENTS.schema.names
    tables.write(
        tables.SEGMENTS, cluster_runs(clusters)[columns], _path(folder, region, fingerprint)
    )


def recall(folder: Path, region: str, fingerprint: str) -> pd.DataFrame | None:
    """The `segments` of a fit, or None where nobody kept them."""
    path = _path(folder, region, fingerprint)
    return tables.read(tables.SEGMENTS, path) if path.exists() else None


def _path(folder: Path, region: str, fingerprint: str) -> Path:
    return Path(folder) / f"{region}-{fingerprint}.parquet"
