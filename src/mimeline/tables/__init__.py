"""The tables' contract: each declared once, cast and checked on write and on read.

A table is Parquet. It is written beside its target and moved into place, so a file that exists is
whole. An empty table may carry the reason why it is empty.
"""

from mimeline.tables.files import empty, read, read_all, reason, write
from mimeline.tables.schemas import (
    ATTRIBUTES,
    AXES,
    CLIPS,
    CLUSTERS,
    COEFFICIENTS,
    DESCRIPTIONS,
    DUPLICATES,
    EXEMPLARS,
    FINGERPRINTS,
    FRAMES,
    INTERVALS,
    LABELS,
    LEDGER,
    LOSSES,
    METRICS,
    MOTION,
    ORIGINS,
    PROFILES,
    SEGMENTS,
    SERIES,
    SOURCE_TIMES,
    SPLIT,
    STATISTICS,
    SWEEP,
    WEIGHTS,
)
from mimeline.tables.table import Table

__all__ = [
    "ATTRIBUTES",
    "AXES",
    "CLIPS",
    "CLUSTERS",
    "COEFFICIENTS",
    "DESCRIPTIONS",
    "DUPLICATES",
    "EXEMPLARS",
    "FINGERPRINTS",
    "FRAMES",
    "INTERVALS",
    "LABELS",
    "LEDGER",
    "LOSSES",
    "METRICS",
    "MOTION",
    "ORIGINS",
    "PROFILES",
    "SEGMENTS",
    "SERIES",
    "SOURCE_TIMES",
    "SPLIT",
    "STATISTICS",
    "SWEEP",
    "WEIGHTS",
    "Table",
    "empty",
    "read",
    "read_all",
    "reason",
    "write",
]
