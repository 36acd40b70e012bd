"""Tables of scores and of what studies find."""

import pandera.pandas as pandera
import pyarrow as pa

from mimeline.tables.columns import COUNT, INTEGER, REAL, SHARE, TEXT, at_least, isin
from mimeline.tables.table import declare
from mimeline.vocabulary import ACTIONS, NEUTRAL, SERIES_REGIONS, TRACKS

METRICS = declare(
    "metrics",
    {
        "model": TEXT,
        "variant": TEXT,
        "part": TEXT,
        "metric": TEXT,
        "value": REAL,
        "low": REAL,
        "high": REAL,
        "n": COUNT,
        "seed": (pa.int64(), True, None),
    },
    order=[],
)

CONFUSION = declare(
    "confusion",
    {
        "variant": TEXT,
        "track": (pa.string(), False, isin(TRACKS)),
        "truth": (pa.string(), False, isin([*ACTIONS, NEUTRAL])),
        "found": (pa.string(), False, isin([*ACTIONS, NEUTRAL])),
        "frames": COUNT,
        "share": (pa.float64(), True, [SHARE]),  # of the frames of that truth
        "low": (pa.float64(), True, [SHARE]),
        "high": (pa.float64(), True, [SHARE]),
    },
    order=["variant", "track"],
    key=["variant", "track", "truth", "found"],
)

SWEEP = declare(
    "sweep",
    {
        "region": (pa.string(), False, isin(SERIES_REGIONS)),
        "n_clusters": (pa.int64(), False, at_least(1)),
        "beta": (pa.float64(), False, at_least(0)),
        "seed": INTEGER,
        "objective": (pa.float64(), False, None),
        "bic": (pa.float64(), False, None),
        "n_switches": COUNT,
        "mean_frames": (pa.float64(), False, at_least(1)),
        "used": (pa.int64(), False, at_least(1)),
        "stability": (pa.float64(), True, [pandera.Check.in_range(-1, 1)]),
        "f1": (pa.float64(), True, [SHARE]),
    },
    order=["region", "n_clusters", "beta", "seed"],
    key=["region", "n_clusters", "beta", "seed"],
)

# Of which class the frames of a clip are, and of which a setting finds them to be.
EXPERIMENTS = declare(
    "experiments",
    {
        "region": (pa.string(), False, isin(SERIES_REGIONS)),
        "experiment": TEXT,
        "setting": TEXT,
        "seed": INTEGER,
        "clip_id": TEXT,
        "truth": (pa.string(), False, isin([*ACTIONS, NEUTRAL])),
        "found": (pa.string(), False, isin([*ACTIONS, NEUTRAL])),
        "frames": COUNT,
    },
    order=["region", "experiment", "setting", "seed", "clip_id", "truth", "found"],
    key=["region", "experiment", "setting", "seed", "clip_id", "truth", "found"],
)

LEFT_OUT = declare(
    "left_out",
    {
        "region": (pa.string(), False, isin(SERIES_REGIONS)),
        "experiment": TEXT,
        "setting": TEXT,
        "reason": TEXT,
    },
    order=[],
    key=["region", "experiment", "setting"],
)
