from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.annotation.segment import segment
from mimeline.annotation.series import series
from mimeline.vocabulary import SERIES_REGIONS

TICC_OPTIONS = {
    "n_clusters": 3,
    "window": 2,
    "beta": 5.0,
    "sparsity": 0.1,
    "boundary": "mask",
    "null_length": 100,
    "null_value": -1.0,
    "max_iter": 5,
    "seed": 0,
}


@pytest.fixture(scope="session")
def motion_of():
    return _motion_of


def _motion_of(lengths: dict[str, int], **channels) -> pd.DataFrame:
    """A `motion` table: channels by name, a number or one per row; the others are not measured."""
    keys = {
        "clip_id": pd.Series([clip for clip, n in lengths.items() for _ in range(n)]),
        "frame": [frame for length in lengths.values() for frame in range(length)],
        "valid": True,
    }
    told = dict.fromkeys(tables.MOTION.schema.names, np.nan) | keys | channels
    table = pd.DataFrame(
        {name: told[name] for name in tables.MOTION.schema.names},  # of assign, one copy each
        index=pd.RangeIndex(len(keys["frame"])),
    )
    return table.astype({"frame": "int64"})


@pytest.fixture(scope="session")
def write_clips():
    return _write_clips


def _write_clips(ids: list[str], path: Path) -> Path:
    rows = pd.DataFrame({"clip_id": ids}).reindex(columns=tables.CLIPS.schema.names)
    rows = rows.assign(source_id="s", start_s=0.0, end_s=1.0, shard=0)
    empty = pd.Series([[]] * len(rows), dtype=object, index=rows.index)
    tables.write(
        tables.CLIPS,
        rows.assign(actions=empty, emotions=empty, attributes=empty, texts=empty),
        path,
    )
    return path


def _planted() -> pd.DataFrame:
    """Three clips whose brow rests, rises and lowers, and whose eye rests, squints and widens."""
    rng = np.random.default_rng(0)
    lengths = dict.fromkeys("abc", 240)
    row = np.arange(3 * 240)
    brow, eye = row // 40 % 3, row // 30 % 3

    def channel(on, size):
        return np.clip(size * on + 0.05 + 0.03 * rng.normal(size=len(row)), 0, 1)

    return _motion_of(
        lengths,
        browInnerUp=channel(brow == 1, 0.6),
        browOuterUpLeft=channel(brow == 1, 0.6),
        browDownLeft=channel(brow == 2, 0.5),
        eyeSquintLeft=channel(eye == 1, 0.5),
        eyeWideLeft=channel(eye == 2, 0.5),
    )


@pytest.fixture(scope="session")
def segmented(tmp_path_factory) -> SimpleNamespace:
    """Brow and eye segmented, the mouth not measured: tables and model folders by region."""
    root = tmp_path_factory.mktemp("segmented")
    motion = _planted()
    tables.write(tables.MOTION, motion, root / "motion.parquet")
    clips = _write_clips(list("abc"), root / "clips.parquet")
    found = SimpleNamespace(motion=motion, series={}, clusters={}, models={})
    for region in SERIES_REGIONS:
        found.series[region] = root / f"{region}.series.parquet"
        found.clusters[region] = root / f"{region}.clusters.parquet"
        found.models[region] = root / f"{region}.model"
        series([clips], [root / "motion.parquet"], found.series[region], region, "left", 100, -1.0)
        paths = found.series[region], found.models[region], found.clusters[region]
        segment(*paths, region=region, side="left", **TICC_OPTIONS)
    return found
