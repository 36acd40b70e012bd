import tracemalloc

import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.dataset.statistics import statistics
from mimeline.vocabulary import CHANNELS


def motion_of(valid, **channels) -> pd.DataFrame:
    table = pd.DataFrame({"clip_id": "a", "frame": range(len(valid)), "valid": valid, **channels})
    absent = {n: np.nan for n in tables.MOTION.schema.names if n not in table}
    return table.assign(**absent)[tables.MOTION.schema.names]


def test_mean_and_spread_are_those_of_the_frames():
    row = statistics(motion_of([True] * 4, jawOpen=[0.0, 0.2, 0.4, 0.6])).set_index("channel")
    expected = [1.0, 0.3, np.sqrt(0.05), 0.0, 0.6]
    columns = ["measured", "mean", "std", "low", "high"]
    assert row.loc["jawOpen", columns].tolist() == pytest.approx(expected)


def test_frames_that_are_not_valid_do_not_count():
    motion = motion_of([True, False, True], jawOpen=[0.2, 1.0, 0.4], head_yaw_left=[0.1, -3.0, 0.3])
    rows = statistics(motion).set_index("channel")
    assert rows.loc["jawOpen", "high"] == pytest.approx(0.4)
    assert rows.loc["head_yaw_left", "mean"] == pytest.approx(0.2)
    assert rows.loc["head_yaw_left", "low"] == pytest.approx(0.1)
    assert rows.loc["jawOpen", "measured"] == 1


def test_measured_is_the_share_of_valid_frames_that_have_the_channel():
    motion = motion_of([True, True, True, True, False], jawOpen=[0.1, np.nan, 0.3, np.nan, 0.9])
    rows = statistics(motion).set_index("channel")
    assert rows.loc["jawOpen", "measured"] == 0.5
    assert rows.loc["jawOpen", "mean"] == pytest.approx(0.2)
    assert rows.loc["cheekPuff", "measured"] == 0
    assert rows.loc["cheekPuff", ["mean", "std", "low", "high"]].isna().all()


@pytest.mark.parametrize("motion", [motion_of([]), motion_of([False, False], jawOpen=0.5)])
def test_without_a_valid_frame_nothing_is_measured_and_every_channel_is_listed(motion, tmp_path):
    tables.write(tables.STATISTICS, statistics(motion), tmp_path / "statistics.parquet")
    rows = tables.read(tables.STATISTICS, tmp_path / "statistics.parquet")
    assert rows["channel"].tolist() == list(CHANNELS)
    assert (rows["measured"] == 0).all()
    assert rows["mean"].isna().all()


def test_statistics_take_little_memory_beside_the_motion():
    motion = motion_of([True] * 20_000, **dict.fromkeys(CHANNELS, np.float32(0.5)))
    tracemalloc.start()
    statistics(motion)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 0.5 * motion.memory_usage().sum()
