"""Tables of clips, what became of them, how they move and how they are described."""

from collections.abc import Iterable

import numpy as np
import pandera.pandas as pandera
import pyarrow as pa

from mimeline.tables.columns import COUNT, INTEGER, NAME, REAL, SHARE, STRING, TEXT, at_least, isin
from mimeline.tables.table import Table, declare
from mimeline.vocabulary import CHANNELS, EXPRESSIONS, REPRESENTATIONS

# An interval of seconds within the clip; each edge may lie uncertainty_s earlier or later.
_TIMED = pa.list_(
    pa.struct(
        {
            "name": STRING,
            "start_s": pa.float64(),
            "end_s": pa.float64(),
            "uncertainty_s": pa.float64(),
        }
    )
)

CLIPS = declare(
    "clips",
    {
        "clip_id": TEXT,
        "source_id": TEXT,
        "subject_id": NAME,
        "start_s": (pa.float64(), False, at_least(0)),
        "end_s": (pa.float64(), False, None),
        "fps_num": (pa.int64(), True, at_least(1)),
        "fps_den": (pa.int64(), True, at_least(1)),
        "n_frames": (pa.int64(), True, at_least(0)),
        "width": (pa.int64(), True, at_least(1)),
        "height": (pa.int64(), True, at_least(1)),
        "bbox_top": REAL,
        "bbox_bottom": REAL,
        "bbox_left": REAL,
        "bbox_right": REAL,
        "actions": (_TIMED, False, None),
        "emotion": NAME,  # of several, the one that is shown the longest
        "emotions": (_TIMED, False, None),
        "attributes": (pa.list_(STRING), False, None),  # what holds for the whole clip
        "texts": (pa.list_(pa.string()), False, None),
        "video": NAME,  # the source's file under data_dir; null: looked for by its name
        "audio": NAME,
        "media": NAME,
        "shard": COUNT,
    },
    order=["clip_id"],
    key=["clip_id"],
)

LEDGER = declare(
    "ledger",
    {
        "clip_id": TEXT,
        "stage": TEXT,
        "status": (pa.string(), False, isin(["kept", "dropped", "failed"])),
        "rule": NAME,
        "value": REAL,
        "limit": REAL,
        "unit": NAME,
        "first_frame": (pa.int64(), True, None),
        "last_frame": (pa.int64(), True, None),
        "detail": NAME,
    },
    order=["stage", "clip_id", "rule"],
    key=["stage", "clip_id", "rule"],
)

SOURCE_TIMES = declare(
    "source_times",
    {
        "clip_id": TEXT,
        "frame": COUNT,
        "source_frame": (pa.int64(), True, at_least(0)),
        "source_s": (pa.float64(), False, None),
    },
    order=["clip_id", "frame"],
    key=["clip_id", "frame"],
)

FINGERPRINTS = declare(
    "fingerprints",
    {"clip_id": TEXT, "frame": COUNT, "bits": INTEGER},
    order=["clip_id", "frame"],
    key=["clip_id", "frame"],
)

_EXPRESSION = (pa.float32(), True, [pandera.Check.in_range(-1.0, 2.0)])
_ANGLE = (pa.float32(), True, [pandera.Check.in_range(-np.pi - 1e-3, np.pi + 1e-3)])

MOTION = declare(
    "motion",
    {
        "clip_id": TEXT,
        "frame": COUNT,
        "valid": (pa.bool_(), False, None),
        "confidence": REAL,
        "tracker_loss": REAL,
        **{name: _EXPRESSION if name in EXPRESSIONS else _ANGLE for name in CHANNELS},
    },
    order=["clip_id", "frame"],
    key=["clip_id", "frame"],
)

AXES = ("x", "y", "z")
UNITS_INTENSE = (1, 2, 4, 5, 6, 7, 9, 10, 12, 14, 15, 17, 20, 23, 25, 26, 45)
UNITS_PRESENT = (*UNITS_INTENSE[:-1], 28, 45)


def _coefficients(name: str, columns: Iterable[str]) -> Table:
    numbers = dict.fromkeys(columns, (pa.float32(), True, None))
    keys = {"clip_id": TEXT, "frame": COUNT}
    order = ["clip_id", "frame"]
    return declare(name, keys | numbers, order=order, key=order)


_COLUMNS: dict[str, list[str]] = {
    "flame": [
        *(f"exp{number:03d}" for number in range(100)),
        *(
            f"{joint}_{axis}"  # axis times angle, radians, in FLAME's axes
            for joint in ("head", "neck", "jaw", "left_eye", "right_eye")
            for axis in AXES
        ),
        *("eyelid_left", "eyelid_right"),
    ],
    "bfm": [
        *(f"exp{number:03d}" for number in range(64)),
        *(f"angle_{axis}" for axis in AXES),
        *(f"translation_{axis}" for axis in AXES),
    ],
    "action_units": [
        *(f"AU{unit:02d}_r" for unit in UNITS_INTENSE),  # 0-5
        *(f"AU{unit:02d}_c" for unit in UNITS_PRESENT),  # 0 or 1
    ],
    "landmarks": [f"{axis}_{point:02d}" for axis in "xy" for point in range(68)],
}
# Other representations of the same frames, in their own formats' units and axes.
COEFFICIENTS: dict[str, Table] = {
    name: _coefficients(name, _COLUMNS[name]) for name in REPRESENTATIONS
}

ORIGINS = declare(
    "origins",
    {
        "channel": (pa.string(), False, isin(CHANNELS)),
        "measured": (pa.bool_(), False, None),
        "origin": NAME,
        "quality": (pa.float64(), True, [SHARE]),
    },
    order=[],
    key=["channel"],
)

DESCRIPTIONS = declare(
    "descriptions",
    {
        "clip_id": TEXT,
        "source": (pa.string(), False, isin(["catalogue", "timeline"])),
        "number": COUNT,
        "text": TEXT,
    },
    order=["clip_id", "source", "number"],
    key=["clip_id", "source", "number"],
)

ATTRIBUTES = declare(
    "attributes",
    {
        "kind": (pa.string(), False, isin(["action", "emotion", "attribute", "timeline"])),
        "attribute": TEXT,
        "clips": COUNT,
        "share": (pa.float64(), False, [SHARE]),
        "seconds": (pa.float64(), True, at_least(0)),
    },
    order=["kind", "attribute"],
    key=["kind", "attribute"],
)

WEIGHTS = declare(
    "weights",
    {"clip_id": TEXT, "weight": (pa.float64(), False, [pandera.Check.gt(0)])},
    order=["clip_id"],
    key=["clip_id"],
)
