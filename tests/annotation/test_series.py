import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.annotation.series import concatenate, dead_channels, sequences, series

BROW = ["browDownLeft", "browInnerUp", "browOuterUpLeft"]


def brow(motion_of, lengths, **more):
    """Motion whose browInnerUp tells the row, in hundredths."""
    rows = sum(lengths.values())
    values = {"browInnerUp": np.arange(rows) / 100, "browDownLeft": 0.1, "browOuterUpLeft": 0.2}
    return motion_of(lengths, **(values | more))


@pytest.fixture
def run(tmp_path, write_clips):
    def run(motion, kept=("a", "b", "c"), region="brow", null_length=4, null_value=-1.0):
        clips = write_clips(list(kept), tmp_path / "clips.parquet")
        tables.write(tables.MOTION, motion, tmp_path / "motion.parquet")
        out = tmp_path / "series.parquet"
        series([clips], [tmp_path / "motion.parquet"], out, region, "left", null_length, null_value)
        return tables.read(tables.SERIES[region, "left"], out), tables.reason(out)

    return run


def test_separators_stand_between_sequences_and_never_at_the_ends(run, motion_of):
    table, reason = run(brow(motion_of, {"a": 3, "b": 1, "c": 2}))
    assert reason == ""
    assert table["clip_id"].fillna("-").tolist() == [*"aaa----b----cc"]
    nulls = table[table["clip_id"].isna()]
    assert (nulls[BROW] == -1).all(axis=None)
    assert nulls["frame"].isna().all()
    assert not (table.dropna()[BROW] == -1).any(axis=None)


def test_length_and_value_of_a_separator_are_as_asked(run, motion_of):
    table, _ = run(brow(motion_of, {"a": 2, "b": 2}), null_length=1, null_value=-7.5)
    assert table["browInnerUp"].tolist() == pytest.approx([0.0, 0.01, -7.5, 0.02, 0.03])


def test_positions_count_up_without_a_hole(run, motion_of):
    table, _ = run(brow(motion_of, {"a": 5, "b": 3, "c": 4}))
    assert table["position"].tolist() == list(range(5 + 4 + 3 + 4 + 4))


def test_a_clip_with_masked_frames_gives_a_sequence_per_stretch(run, motion_of):
    motion = brow(motion_of, {"a": 6, "b": 2})
    motion.loc[2, "valid"] = False
    motion.loc[4, "browDownLeft"] = np.nan
    table, _ = run(motion)
    frames, lengths = sequences(table)
    assert lengths.tolist() == [2, 1, 1, 2]
    assert frames["frame"].tolist() == [0, 1, 3, 5, 0, 1]
    assert len(table) == 6 + 3 * 4


def test_clips_that_were_not_kept_stay_out(run, motion_of):
    table, _ = run(brow(motion_of, {"a": 2, "b": 2, "c": 2}), kept=["b"])
    assert table["clip_id"].tolist() == ["b", "b"]


def test_a_channel_that_is_not_measured_leaves_an_empty_series_that_names_it(run, motion_of):
    table, reason = run(brow(motion_of, {"a": 3}, browDownLeft=np.nan))
    assert table.empty
    assert reason == "not measured: browDownLeft"


def test_channels_that_are_never_measured_together_say_so(run, motion_of):
    half = np.array([0.1, np.nan])
    motion = brow(motion_of, {"a": 2}, browDownLeft=half, browInnerUp=half[::-1])
    assert run(motion)[1].startswith("not measured in one frame: browDownLeft, browInnerUp")


def test_no_clip_and_no_valid_frame_are_told_apart(run, motion_of):
    assert run(motion_of({}), kept=[])[1] == "no clip came through"
    assert run(brow(motion_of, {"a": 3}), kept=["b"])[1] == "no clip came through"
    motion = brow(motion_of, {"a": 3}).assign(valid=False)
    assert run(motion)[1] == "no frame is valid"


def test_one_sequence_needs_no_separator():
    frames = pd.DataFrame({"clip_id": "a", "frame": [4, 5], "jawOpen": [0.1, 0.2]})
    table = concatenate(frames, ["jawOpen"], null_length=100, null_value=-1.0)
    assert table["frame"].tolist() == [4, 5]
    assert sequences(table)[1].tolist() == [2]


def test_a_channel_is_dead_where_its_range_without_rare_frames_is_small():
    row = np.arange(1000)
    values = pd.DataFrame(
        {
            "jitter": 0.3 + 0.009 * (-1.0) ** row,
            "glitch": np.where(row == 5, 1.0, 0.3),
            "rare": np.where(row < 10, 0.5, 0.0),
            "moving": row / 1000,
        }
    )
    assert dead_channels(values) == ["jitter", "glitch"]
    assert dead_channels(values[:0]) == []
