"""The tables' contract: each declared once, cast and checked on write and on read.

A table is Parquet. It is written beside its target and moved into place, so a file that exists is
whole. An empty table may carry the reason why it is empty.
"""

from mimeline.tables.files import empty, read, read_all, reason, write
from mimeline.tables.schemas import (
    AXES,
    CLIPS,
    CLUSTERS,
    COEFFICIENTS,
    EXEMPLARS,
    FRAMES,
    INTERVALS,
    LABELS,
    LEDGER,
    LOSSES,
    METRICS,
    MOTION,
    ORIGINS,
    SERIES,
    SOURCE_TIMES,
    SPLIT,
    STATISTICS,
    SWEEP,
)
from mimeline.tables.table import Table

__all__ = [
    "AXES",
    "CLIPS",
    "CLUSTERS",
    "COEFFICIENTS",
    "EXEMPLARS",
    "FRAMES",
    "INTERVALS",
    "LABELS",
    "LEDGER",
    "LOSSES",
    "METRICS",
    "MOTION",
    "ORIGINS",
    "SERIES",
    "SOURCE_TIMES",
    "SPLIT",
    "STATISTICS",
    "SWEEP",
    "Table",
    "empty",
    "read",
    "read_all",
    "reason",
    "write",
]
