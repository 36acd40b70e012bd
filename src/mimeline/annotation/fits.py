"""The clusters of every fit that names may belong to, kept beside the results: names move by them.

They are no output of a rule: a refit must not delete what the names of the fit before are moved by.
"""

import contextlib
import logging
import os
from pathlib import Path

import pandas as pd

from mimeline import tables
from mimeline.annotation.runs import cluster_runs
from mimeline.errors import MimelineError

log = logging.getLogger(__name__)

MOST = 50  # fits kept of a region: those that were used last


def remember(folder: Path, region: str, fingerprint: str, clusters: pd.DataFrame) -> None:
    """Keep a fit's clusters. clusters: the `clusters` table.

    What is there is written anew: the same fit may be that of clips which were renamed.
    """
    columns = tables.SEGMENTS.schema.names
    segments = cluster_runs(clusters)[columns]
    tables.write(tables.SEGMENTS, segments, _path(folder, region, fingerprint))
    kept = sorted(Path(folder).glob(f"{region}-*.parquet"), key=_last_used, reverse=True)
    for path in kept[MOST:]:
        path.unlink(missing_ok=True)


def recall(folder: Path, region: str, fingerprint: str) -> pd.DataFrame | None:
    """The `segments` of a fit, or None where nobody kept them or the file is broken."""
    path = _path(folder, region, fingerprint)
    if not path.exists():
        return None
    try:
        segments = tables.read(tables.SEGMENTS, path)
    except MimelineError as error:
        log.warning("what was kept of a fit is not used: %s", error)
        return None
    with contextlib.suppress(OSError):  # results that may only be read
        os.utime(path)
    return segments


def _path(folder: Path, region: str, fingerprint: str) -> Path:
    return Path(folder) / f"{region}-{fingerprint}.parquet"


def _last_used(path: Path) -> float:
    try:
        return path.stat().st_mtime
    except FileNotFoundError:  # another process made room
        return 0.0
