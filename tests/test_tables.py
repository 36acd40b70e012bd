import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mimeline import tables
from mimeline.errors import BadFile, MissingColumn
from mimeline.vocabulary import ACTIONS

EVERY_TABLE = [t for t in vars(tables).values() if isinstance(t, tables.Table)] + list(
    tables.SERIES.values()
)


@pytest.mark.parametrize("table", EVERY_TABLE, ids=lambda table: table.name)
def test_an_empty_table_keeps_its_types_and_its_reason(tmp_path, table):
    path = tmp_path / "t.parquet"
    tables.write(table, tables.empty(table), path, reason="nothing came in")
    assert pq.read_schema(path).remove_metadata().equals(table.schema)
    assert tables.reason(path) == "nothing came in"
    assert tables.read(table, path).empty


def test_what_else_is_to_be_known_of_a_table_travels_in_its_file(tmp_path):
    path = tmp_path / "t.parquet"
    tables.write(tables.LEDGER, tables.empty(tables.LEDGER), path, about='{"fps": "30"} \u00e9')
    assert tables.about(path) == '{"fps": "30"} \u00e9' and tables.reason(path) == ""
    tables.write(tables.LEDGER, tables.empty(tables.LEDGER), path)
    assert tables.about(path) == ""


marks = st.lists(
    st.tuples(
        st.sampled_from(["a", "-b", "c_0"]),
        st.integers(0, 10_000),
        st.sampled_from([True, False, None]),
    ),
    max_size=20,
)


@settings(max_examples=30, deadline=None)
@given(marks)
def test_frames_come_back_as_they_were_with_null_for_not_measured(tmp_path_factory, rows):
    path = tmp_path_factory.mktemp("frames") / "frames.parquet"
    frames = pd.DataFrame(rows, columns=["clip_id", "frame", "BrowUp"]).drop_duplicates(
        ["clip_id", "frame"]
    )
    frames["BrowUp"] = frames["BrowUp"].astype("boolean")
    frames = frames.reindex(columns=tables.FRAMES.schema.names)
    frames[[a for a in ACTIONS if a != "BrowUp"]] = False
    tables.write(tables.FRAMES, frames, path)
    back = tables.read(tables.FRAMES, path)
    expected = frames.sort_values(["clip_id", "frame"], ignore_index=True)
    assert back["clip_id"].tolist() == expected["clip_id"].tolist()
    assert back["frame"].tolist() == expected["frame"].tolist()
    assert back["BrowUp"].isna().tolist() == expected["BrowUp"].isna().tolist()
    assert back["BrowUp"].fillna(False).tolist() == expected["BrowUp"].fillna(False).tolist()


def test_rows_are_sorted_by_clip_and_frame(tmp_path):
    rows = pd.DataFrame(
        {"clip_id": ["b", "a", "a"], "frame": [0, 1, 0], "cluster": 0, "margin": 0.0}
    )
    tables.write(tables.CLUSTERS, rows, tmp_path / "t.parquet")
    back = tables.read(tables.CLUSTERS, tmp_path / "t.parquet")
    assert list(zip(back["clip_id"], back["frame"], strict=True)) == [("a", 0), ("a", 1), ("b", 0)]


def test_a_value_that_is_not_allowed_leaves_no_file(tmp_path):
    path = tmp_path / "t.parquet"
    rows = pd.DataFrame({"clip_id": ["a"], "part": ["exam"], "group": ["g"]})
    with pytest.raises(BadFile, match="column part.*'exam'"):
        tables.write(tables.SPLIT, rows, path)
    assert list(tmp_path.iterdir()) == []


def test_a_failed_write_keeps_the_last_good_file(tmp_path):
    path = tmp_path / "t.parquet"
    rows = pd.DataFrame({"clip_id": ["a"], "part": ["val"], "group": ["g"]})
    tables.write(tables.SPLIT, rows, path)
    with pytest.raises(BadFile):
        tables.write(tables.SPLIT, rows.assign(part="exam"), path)
    assert tables.read(tables.SPLIT, path)["part"].tolist() == ["val"]


def test_a_missing_column_and_a_null_key_are_refused(tmp_path):
    rows = pd.DataFrame({"clip_id": ["a"], "part": ["val"], "group": ["g"]})
    with pytest.raises(MissingColumn, match="group"):
        tables.write(tables.SPLIT, rows.drop(columns="group"), tmp_path / "t.parquet")
    with pytest.raises(BadFile):
        tables.write(tables.SPLIT, rows.assign(clip_id=None), tmp_path / "t.parquet")


def test_an_interval_holds_at_least_a_frame(tmp_path):
    row = {
        "clip_id": ["a"],
        "track": "brow",
        "action": "BrowUp",
        "start_frame": 5,
        "end_frame": 5,
        "side": None,
        "source": "ticc",
        "cluster": 0,
        "confidence": np.nan,
    }
    with pytest.raises(BadFile, match="half-open"):
        tables.write(tables.INTERVALS, pd.DataFrame(row), tmp_path / "t.parquet")


def test_a_file_that_is_no_parquet_says_what_to_do(tmp_path):
    (tmp_path / "t.parquet").write_text("no table")
    with pytest.raises(BadFile, match="run its stage again"):
        tables.read(tables.SPLIT, tmp_path / "t.parquet")


def test_a_table_of_other_types_or_with_a_row_twice_is_refused(tmp_path):
    path = tmp_path / "t.parquet"
    rows = pd.DataFrame({"clip_id": ["a", "a"], "frame": [0, 0], "cluster": 0, "margin": 0.0})
    with pytest.raises(BadFile):
        tables.write(tables.CLUSTERS, rows, path)
    rows.assign(frame=[0, 1], cluster="first").to_parquet(path)
    with pytest.raises(BadFile, match="columns of the declared types"):
        tables.read(tables.CLUSTERS, path)


def test_a_table_that_a_person_made_needs_the_columns_and_not_the_exact_types(tmp_path):
    path = tmp_path / "t.parquet"
    rows = pd.DataFrame({"clip_id": ["a"], "frame": [0], "cluster": [3.0], "margin": [1]})
    rows.to_parquet(path)
    assert tables.read(tables.CLUSTERS, path)["cluster"].tolist() == [3]
