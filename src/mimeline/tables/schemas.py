"""The tables' contract: each declared once."""

from collections.abc import Iterable

import numpy as np
import pandera.pandas as pandera
import pyarrow as pa

from mimeline.tables.table import Table, declare
from mimeline.vocabulary import (
    ACTIONS,
    CHANNELS,
    EXPRESSIONS,
    NEUTRAL,
    REPRESENTATIONS,
    SERIES_REGIONS,
    TRACKS,
    series_channels,
)


def _isin(values: Iterable[str]) -> list[pandera.Check]:
    return [pandera.Check.isin(list(values))]


def _at_least(least: float) -> list[pandera.Check]:
    return [pandera.Check.ge(least)]


_S = pa.string()
_TEXT, _NAME = (_S, False, None), (_S, True, None)
_INT, _COUNT = (pa.int64(), False, None), (pa.int64(), False, _at_least(0))
_REAL = (pa.float64(), True, None)
_SHARE = pandera.Check.in_range(0, 1)
_INTERVAL = pandera.Check(
    lambda t: t["end_frame"] > t["start_frame"], name="half-open interval of at least a frame"
)

# An interval of seconds within the clip; each edge may lie uncertainty_s earlier or later.
_TIMED = pa.list_(
    pa.struct(
        {
            "name": _S,
            "start_s": pa.float64(),
            "end_s": pa.float64(),
            "uncertainty_s": pa.float64(),
        }
    )
)

CLIPS = declare(
    "clips",
    {
        "clip_id": _TEXT,
        "source_id": _TEXT,
        "subject_id": _NAME,
        "start_s": (pa.float64(), False, _at_least(0)),
        "end_s": (pa.float64(), False, None),
        "fps_num": (pa.int64(), True, _at_least(1)),
        "fps_den": (pa.int64(), True, _at_least(1)),
        "n_frames": (pa.int64(), True, _at_least(0)),
        "width": (pa.int64(), True, _at_least(1)),
        "height": (pa.int64(), True, _at_least(1)),
        "bbox_top": _REAL,
        "bbox_bottom": _REAL,
        "bbox_left": _REAL,
        "bbox_right": _REAL,
        "actions": (_TIMED, False, None),
        "emotion": _NAME,  # of several, the one that is shown the longest
        "emotions": (_TIMED, False, None),
        "attributes": (pa.list_(_S), False, None),  # what holds for the whole clip
        "texts": (pa.list_(pa.string()), False, None),
        "video": _NAME,  # the source's file under data_dir; null: looked for by its name
        "audio": _NAME,
        "media": _NAME,
        "shard": _COUNT,
    },
    order=["clip_id"],
    key=["clip_id"],
)

LEDGER = declare(
    "ledger",
    {
        "clip_id": _TEXT,
        "stage": _TEXT,
        "status": (pa.string(), False, _isin(["kept", "dropped", "failed"])),
        "rule": _NAME,
        "value": _REAL,
        "limit": _REAL,
        "unit": _NAME,
        "first_frame": (pa.int64(), True, None),
        "last_frame": (pa.int64(), True, None),
        "detail": _NAME,
    },
    order=["stage", "clip_id", "rule"],
    key=["stage", "clip_id", "rule"],
)

SOURCE_TIMES = declare(
    "source_times",
    {
        "clip_id": _TEXT,
        "frame": _COUNT,
        "source_frame": (pa.int64(), True, _at_least(0)),
        "source_s": (pa.float64(), False, None),
    },
    order=["clip_id", "frame"],
    key=["clip_id", "frame"],
)

FINGERPRINTS = declare(
    "fingerprints",
    {"clip_id": _TEXT, "frame": _COUNT, "bits": _INT},
    order=["clip_id", "frame"],
    key=["clip_id", "frame"],
)

_EXPRESSION = (pa.float32(), True, [pandera.Check.in_range(-1.0, 2.0)])
_ANGLE = (pa.float32(), True, [pandera.Check.in_range(-np.pi - 1e-3, np.pi + 1e-3)])

MOTION = declare(
    "motion",
    {
        "clip_id": _TEXT,
        "frame": _COUNT,
        "valid": (pa.bool_(), False, None),
        "confidence": _REAL,
        "tracker_loss": _REAL,
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
    keys = {"clip_id": _TEXT, "frame": _COUNT}
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
        "channel": (pa.string(), False, _isin(CHANNELS)),
        "measured": (pa.bool_(), False, None),
        "origin": _NAME,
        "quality": (pa.float64(), True, [_SHARE]),
    },
    order=[],
    key=["channel"],
)


def _series(region: str, side: str) -> Table:
    channels = {name: (pa.float32(), False, None) for name in series_channels(region, side)}
    columns = {
        "position": _COUNT,
        "clip_id": _NAME,
        "frame": (pa.int64(), True, _at_least(0)),
        **channels,
    }
    return declare("series", columns, order=["position"])


SERIES: dict[tuple[str, str], Table] = {
    (region, side): _series(region, side) for region in SERIES_REGIONS for side in ("left", "right")
}

CLUSTERS = declare(
    "clusters",
    {
        "clip_id": _TEXT,
        "frame": _COUNT,
        "cluster": _COUNT,
        "margin": (pa.float32(), False, _at_least(0)),
    },
    order=["clip_id", "frame"],
    key=["clip_id", "frame"],
)

EXEMPLARS = declare(
    "exemplars",
    {
        "region": (pa.string(), False, _isin(SERIES_REGIONS)),
        "cluster": _COUNT,
        "clip_id": _TEXT,
        "start_frame": _COUNT,
        "end_frame": _COUNT,
        "kind": (pa.string(), False, _isin(["medoid", "longest", "border", "random", "further"])),
        "rank": _COUNT,  # in the order in which they are shown
    },
    order=["region", "cluster", "rank"],
    key=["region", "cluster", "rank"],
    frame_checks=_INTERVAL,
)

PROFILES = declare(
    "profiles",
    {
        "region": (pa.string(), False, _isin(SERIES_REGIONS)),
        "cluster": _COUNT,
        "n_frames": _COUNT,
        "n_intervals": _COUNT,
        "n_clips": _COUNT,
        "median_frames": (pa.float64(), False, _at_least(1)),
        "purity": (pa.float64(), True, [_SHARE]),
        "nearest": (pa.int64(), True, _at_least(0)),
        "distance": (pa.float64(), True, None),
    },
    order=["region", "cluster"],
    key=["region", "cluster"],
)

# A fit's clusters as stretches of frames: what its names are moved by, once it is fitted anew.
SEGMENTS = declare(
    "segments",
    {"clip_id": _TEXT, "start_frame": _COUNT, "end_frame": _COUNT, "cluster": _COUNT},
    order=["clip_id", "start_frame"],
    key=["clip_id", "start_frame"],
    frame_checks=_INTERVAL,
)

INTERVALS = declare(
    "intervals",
    {
        "clip_id": _TEXT,
        "track": (pa.string(), False, _isin(TRACKS)),
        "action": (pa.string(), False, _isin(ACTIONS)),
        "start_frame": _COUNT,
        "end_frame": _COUNT,
        "side": (pa.string(), True, _isin(["left", "right"])),
        "source": (pa.string(), False, _isin(["ticc", "threshold", "human"])),
        "cluster": (pa.int64(), True, _at_least(0)),
        "confidence": (pa.float64(), True, [_SHARE]),
    },
    order=["clip_id", "track", "start_frame"],
    frame_checks=_INTERVAL,
)

FRAMES = declare(
    "frames",
    {"clip_id": _TEXT, "frame": _COUNT, **{a: (pa.bool_(), True, None) for a in ACTIONS}},
    order=["clip_id", "frame"],
    key=["clip_id", "frame"],
)

LABELS = declare(
    "labels",
    {
        "region": (pa.string(), False, _isin(SERIES_REGIONS)),
        "cluster": _COUNT,
        "action": (pa.string(), True, _isin([*ACTIONS, NEUTRAL])),  # null: its frames have none
        "note": _NAME,
        "source": (pa.string(), False, _isin(["proposed", "moved", "human"])),
        "share": (pa.float64(), False, [_SHARE]),
        "confidence": (pa.float64(), True, [_SHARE]),
        "why": _NAME,  # there is no action
        "unmeasured": (pa.list_(_S), False, None),  # actions that no channel of the fit tells
    },
    order=["region", "cluster"],
    key=["region", "cluster"],
)

DESCRIPTIONS = declare(
    "descriptions",
    {
        "clip_id": _TEXT,
        "source": (pa.string(), False, _isin(["catalogue", "timeline"])),
        "number": _COUNT,
        "text": _TEXT,
    },
    order=["clip_id", "source", "number"],
    key=["clip_id", "source", "number"],
)

ATTRIBUTES = declare(
    "attributes",
    {
        "kind": (pa.string(), False, _isin(["action", "emotion", "attribute", "timeline"])),
        "attribute": _TEXT,
        "clips": _COUNT,
        "share": (pa.float64(), False, [pandera.Check.in_range(0, 1)]),
        "seconds": (pa.float64(), True, _at_least(0)),
    },
    order=["kind", "attribute"],
    key=["kind", "attribute"],
)

WEIGHTS = declare(
    "weights",
    {"clip_id": _TEXT, "weight": (pa.float64(), False, [pandera.Check.gt(0)])},
    order=["clip_id"],
    key=["clip_id"],
)

DUPLICATES = declare(
    "duplicates",
    {
        "clip_id": _TEXT,
        "other_id": _TEXT,
        "kind": (pa.string(), False, _isin(["film", "motion"])),
        "share": (pa.float64(), False, [pandera.Check.in_range(0, 1)]),
    },
    order=["clip_id", "other_id", "kind"],
    key=["clip_id", "other_id", "kind"],
)

SPLIT = declare(
    "split",
    {
        "clip_id": _TEXT,
        "part": (pa.string(), False, _isin(["train", "val", "test"])),
        "group": _TEXT,
    },
    order=["clip_id"],
    key=["clip_id"],
)

STATISTICS = declare(
    "statistics",
    {
        "channel": (pa.string(), False, _isin(CHANNELS)),
        "measured": (pa.float64(), False, [pandera.Check.in_range(0, 1)]),
        "mean": _REAL,
        "std": _REAL,
        "low": _REAL,
        "high": _REAL,
    },
    order=[],
)

LOSSES = declare(
    "losses",
    {
        "step": _COUNT,
        "loss": (pa.float64(), False, None),
        "val_loss": _REAL,
        "learning_rate": (pa.float64(), False, None),
        "gradient_norm": _REAL,
        "seconds": (pa.float64(), False, None),
    },
    order=["step"],
)

METRICS = declare(
    "metrics",
    {
        "model": _TEXT,
        "variant": _TEXT,
        "part": _TEXT,
        "metric": _TEXT,
        "value": _REAL,
        "low": _REAL,
        "high": _REAL,
        "n": _COUNT,
        "seed": (pa.int64(), True, None),
    },
    order=[],
)


SWEEP = declare(
    "sweep",
    {
        "region": (pa.string(), False, _isin(SERIES_REGIONS)),
        "n_clusters": (pa.int64(), False, _at_least(1)),
        "beta": (pa.float64(), False, _at_least(0)),
        "seed": _INT,
        "objective": (pa.float64(), False, None),
        "bic": (pa.float64(), False, None),
        "n_switches": _COUNT,
        "mean_frames": (pa.float64(), False, _at_least(1)),
        "used": (pa.int64(), False, _at_least(1)),
        "stability": (pa.float64(), True, [pandera.Check.in_range(-1, 1)]),
        "f1": (pa.float64(), True, [_SHARE]),
    },
    order=["region", "n_clusters", "beta", "seed"],
    key=["region", "n_clusters", "beta", "seed"],
)

# Of which class the frames of a clip are, and of which a setting finds them to be.
EXPERIMENTS = declare(
    "experiments",
    {
        "region": (pa.string(), False, _isin(SERIES_REGIONS)),
        "experiment": _TEXT,
        "setting": _TEXT,
        "seed": _INT,
        "clip_id": _TEXT,
        "truth": (pa.string(), False, _isin([*ACTIONS, NEUTRAL])),
        "found": (pa.string(), False, _isin([*ACTIONS, NEUTRAL])),
        "frames": _COUNT,
    },
    order=["region", "experiment", "setting", "seed", "clip_id", "truth", "found"],
    key=["region", "experiment", "setting", "seed", "clip_id", "truth", "found"],
)

LEFT_OUT = declare(
    "left_out",
    {
        "region": (pa.string(), False, _isin(SERIES_REGIONS)),
        "experiment": _TEXT,
        "setting": _TEXT,
        "reason": _TEXT,
    },
    order=[],
    key=["region", "experiment", "setting"],
)

CONFUSION = declare(
    "confusion",
    {
        "variant": _TEXT,
        "track": (pa.string(), False, _isin(TRACKS)),
        "truth": (pa.string(), False, _isin([*ACTIONS, NEUTRAL])),
        "found": (pa.string(), False, _isin([*ACTIONS, NEUTRAL])),
        "frames": _COUNT,
        "share": (pa.float64(), True, [_SHARE]),  # of the frames of that truth
        "low": (pa.float64(), True, [_SHARE]),
        "high": (pa.float64(), True, [_SHARE]),
    },
    order=["variant", "track"],
    key=["variant", "track", "truth", "found"],
)
