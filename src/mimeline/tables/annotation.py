"""Tables from the long series to timelines."""

import pyarrow as pa

from mimeline.tables.columns import COUNT, INTERVAL, NAME, SHARE, STRING, TEXT, at_least, isin
from mimeline.tables.table import Table, declare
from mimeline.vocabulary import ACTIONS, NEUTRAL, SERIES_REGIONS, TRACKS, series_channels


def _series(region: str, side: str) -> Table:
    channels = {name: (pa.float32(), False, None) for name in series_channels(region, side)}
    columns = {
        "position": COUNT,
        "clip_id": NAME,
        "frame": (pa.int64(), True, at_least(0)),
        **channels,
    }
    return declare("series", columns, order=["position"])


SERIES: dict[tuple[str, str], Table] = {
    (region, side): _series(region, side) for region in SERIES_REGIONS for side in ("left", "right")
}

CLUSTERS = declare(
    "clusters",
    {
        "clip_id": TEXT,
        "frame": COUNT,
        "cluster": COUNT,
        "margin": (pa.float32(), False, at_least(0)),
    },
    order=["clip_id", "frame"],
    key=["clip_id", "frame"],
)

EXEMPLARS = declare(
    "exemplars",
    {
        "region": (pa.string(), False, isin(SERIES_REGIONS)),
        "cluster": COUNT,
        "clip_id": TEXT,
        "start_frame": COUNT,
        "end_frame": COUNT,
        "kind": (pa.string(), False, isin(["medoid", "longest", "border", "random", "further"])),
        "rank": COUNT,  # in the order in which they are shown
    },
    order=["region", "cluster", "rank"],
    key=["region", "cluster", "rank"],
    frame_checks=INTERVAL,
)

PROFILES = declare(
    "profiles",
    {
        "region": (pa.string(), False, isin(SERIES_REGIONS)),
        "cluster": COUNT,
        "n_frames": COUNT,
        "n_intervals": COUNT,
        "n_clips": COUNT,
        "median_frames": (pa.float64(), False, at_least(1)),
        "purity": (pa.float64(), True, [SHARE]),
        "nearest": (pa.int64(), True, at_least(0)),
        "distance": (pa.float64(), True, None),
    },
    order=["region", "cluster"],
    key=["region", "cluster"],
)

# A fit's clusters as stretches of frames: what its names are moved by, once it is fitted anew.
SEGMENTS = declare(
    "segments",
    {"clip_id": TEXT, "start_frame": COUNT, "end_frame": COUNT, "cluster": COUNT},
    order=["clip_id", "start_frame"],
    key=["clip_id", "start_frame"],
    frame_checks=INTERVAL,
)

INTERVALS = declare(
    "intervals",
    {
        "clip_id": TEXT,
        "track": (pa.string(), False, isin(TRACKS)),
        "action": (pa.string(), False, isin(ACTIONS)),
        "start_frame": COUNT,
        "end_frame": COUNT,
        "side": (pa.string(), True, isin(["left", "right"])),
        "source": (pa.string(), False, isin(["ticc", "threshold", "human"])),
        "cluster": (pa.int64(), True, at_least(0)),
        "confidence": (pa.float64(), True, [SHARE]),
    },
    order=["clip_id", "track", "start_frame"],
    frame_checks=INTERVAL,
)

FRAMES = declare(
    "frames",
    {"clip_id": TEXT, "frame": COUNT, **{a: (pa.bool_(), True, None) for a in ACTIONS}},
    order=["clip_id", "frame"],
    key=["clip_id", "frame"],
)

LABELS = declare(
    "labels",
    {
        "region": (pa.string(), False, isin(SERIES_REGIONS)),
        "cluster": COUNT,
        "action": (pa.string(), True, isin([*ACTIONS, NEUTRAL])),  # null: its frames have none
        "note": NAME,
        "source": (pa.string(), False, isin(["proposed", "moved", "human"])),
        "share": (pa.float64(), False, [SHARE]),
        "confidence": (pa.float64(), True, [SHARE]),
        "why": NAME,  # there is no action
        "unmeasured": (pa.list_(STRING), False, None),  # actions that no channel of the fit tells
    },
    order=["region", "cluster"],
    key=["region", "cluster"],
)
