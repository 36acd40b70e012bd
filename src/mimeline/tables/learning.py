"""Tables of how clips are divided, and of what a training saw."""

import pyarrow as pa

from mimeline.tables.columns import COUNT, REAL, SHARE, TEXT, isin
from mimeline.tables.table import declare
from mimeline.vocabulary import CHANNELS

DUPLICATES = declare(
    "duplicates",
    {
        "clip_id": TEXT,
        "other_id": TEXT,
        "kind": (pa.string(), False, isin(["film", "motion"])),
        "share": (pa.float64(), False, [SHARE]),
    },
    order=["clip_id", "other_id", "kind"],
    key=["clip_id", "other_id", "kind"],
)

SPLIT = declare(
    "split",
    {
        "clip_id": TEXT,
        "part": (pa.string(), False, isin(["train", "val", "test"])),
        "group": TEXT,
    },
    order=["clip_id"],
    key=["clip_id"],
)

STATISTICS = declare(
    "statistics",
    {
        "channel": (pa.string(), False, isin(CHANNELS)),
        "measured": (pa.float64(), False, [SHARE]),
        "mean": REAL,
        "std": REAL,
        "low": REAL,
        "high": REAL,
    },
    order=[],
)

LOSSES = declare(
    "losses",
    {
        "step": COUNT,
        "loss": (pa.float64(), False, None),
        "val_loss": REAL,
        "learning_rate": (pa.float64(), False, None),
        "gradient_norm": REAL,
        "seconds": (pa.float64(), False, None),
    },
    order=["step"],
)
