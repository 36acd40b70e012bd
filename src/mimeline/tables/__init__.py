"""The tables' contract: each declared once, cast and checked on write and on read.

A table is Parquet. It is written beside its target and moved into place, so a file that exists is
whole. An empty table may carry the reason why it is empty.
"""

from mimeline.tables.annotation import (
    CLUSTERS,
    EXEMPLARS,
    FRAMES,
    INTERVALS,
    LABELS,
    PROFILES,
    SEGMENTS,
    SERIES,
)
from mimeline.tables.files import about, empty, read, read_all, reason, write
from mimeline.tables.learning import DUPLICATES, LOSSES, SPLIT, STATISTICS
from mimeline.tables.recordings import (
    ATTRIBUTES,
    AXES,
    CLIPS,
    COEFFICIENTS,
    DESCRIPTIONS,
    FINGERPRINTS,
    LEDGER,
    MOTION,
    ORIGINS,
    SOURCE_TIMES,
    WEIGHTS,
)
from mimeline.tables.scores import CONFUSION, EXPERIMENTS, LEFT_OUT, METRICS, SWEEP
from mimeline.tables.table import Table

__all__ = [
    "ATTRIBUTES",
    "AXES",
    "CLIPS",
    "CLUSTERS",
    "COEFFICIENTS",
    "CONFUSION",
    "DESCRIPTIONS",
    "DUPLICATES",
    "EXEMPLARS",
    "EXPERIMENTS",
    "FINGERPRINTS",
    "FRAMES",
    "INTERVALS",
    "LABELS",
    "LEDGER",
    "LEFT_OUT",
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
    "about",
    "empty",
    "read",
    "read_all",
    "reason",
    "write",
]
