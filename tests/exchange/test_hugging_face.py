"""`mimeline dataset export --to huggingface`: Parquet that others load, and its card."""

import json

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.dataset as ds
import pyarrow.parquet as pq
import pytest
import yaml

from mimeline import tables
from mimeline.exchange.datasets import export
from mimeline.exchange.hugging_face import _size
from mimeline.exchange.licences import Told
from mimeline.inspection.left_behind import rows_of
from mimeline.vocabulary import ACTIONS, CHANNELS


@pytest.fixture(scope="module")
def exported(divided_once, tmp_path_factory):
    """The folder of an export of the run, and the run's results."""
    folder = tmp_path_factory.mktemp("huggingface") / "out"
    export(divided_once, "huggingface", folder, Told())
    return folder, divided_once


def front_of(folder) -> dict:
    return yaml.safe_load((folder / "README.md").read_text().split("---\n")[1])


def test_each_value_is_that_of_the_runs_own_tables_whatever_reads_it(exported):
    folder, results = exported
    motion, frames = (
        rows_of(results, stage, table).set_index("clip_id")
        for stage, table in (("ingest", tables.MOTION), ("annotate", tables.FRAMES))
    )
    intervals = rows_of(results, "annotate", tables.INTERVALS)
    by_pandas = pd.read_parquet(folder / "data").to_dict("records")
    by_arrow = ds.dataset(folder / "data").to_table().to_pylist()
    assert sorted(row["clip_id"] for row in by_arrow) == sorted(motion.index.unique())
    for row in [*by_pandas, *by_arrow]:
        own, shown = motion.loc[row["clip_id"]], frames.loc[row["clip_id"]]
        moved = pd.DataFrame(dict(row["motion"]), dtype=np.float32)
        assert list(moved) == [name for name in CHANNELS if name != "tongueOut"]
        pd.testing.assert_frame_equal(moved, own[list(moved)].reset_index(drop=True))
        acted = pd.DataFrame(dict(row["actions"]))
        assert list(acted) == list(ACTIONS) and set(acted["GazeLeft"]) == {-1}
        told = shown[list(ACTIONS)].astype("Int8").fillna(-1).reset_index(drop=True)
        assert (acted.to_numpy() == told.to_numpy(np.int8)).all()
        assert list(row["valid"]) == own["valid"].tolist()
        assert np.isnan(np.array(row["tracker_loss"], float)).all()
        mine = intervals[intervals["clip_id"] == row["clip_id"]]
        edges = [(i["action"], i["start_frame"], i["end_frame"]) for i in row["intervals"]]
        assert edges == list(
            zip(mine["action"], mine["start_frame"], mine["end_frame"], strict=True)
        )
        assert row["n_frames"] == len(own) and row["fps"] == row["fps_num"] / row["fps_den"]


def test_parts_are_splits_and_one_without_a_clip_is_none(exported):
    folder, _ = exported
    rows = {path.name: pq.read_table(path).num_rows for path in (folder / "data").iterdir()}
    assert rows == {
        "train-00000-of-00001.parquet": 4,
        "validation-00000-of-00001.parquet": 1,
    }
    assert "; no clip is in test." in (folder / "README.md").read_text()
    front = front_of(folder)
    told = {split["name"]: split["num_examples"] for split in front["dataset_info"]["splits"]}
    assert told == {"train": 4, "validation": 1}
    for file in front["configs"][0]["data_files"]:
        assert list(folder.glob(file["path"]))
    assert front["license"] == "mit" and front["size_categories"] == ["n<1K"]
    stored = sum(path.stat().st_size for path in (folder / "data").iterdir())
    assert front["dataset_info"]["download_size"] == stored


def test_schema_and_card_name_the_same_features_in_words_that_old_and_new_datasets_know(exported):
    folder, _ = exported
    schema = pq.read_schema(folder / "data" / "train-00000-of-00001.parquet")
    told = json.loads(schema.metadata[b"huggingface"])["info"]["features"]
    assert list(told) == schema.names
    assert told["fps"] == {"dtype": "float64", "_type": "Value"}
    assert told["motion"]["jawOpen"] == {
        "feature": {"dtype": "float32", "_type": "Value"},
        "_type": "Sequence",
    }
    assert told["intervals"][0]["start_frame"] == {"dtype": "int64", "_type": "Value"}
    in_card = {own.pop("name"): own for own in front_of(folder)["dataset_info"]["features"]}
    assert list(in_card) == schema.names
    assert in_card["actions"]["struct"][0] == {"name": "BrowUp", "list": "int8"}
    assert in_card["intervals"]["list"][2] == {"name": "start_frame", "dtype": "int64"}
    assert in_card["descriptions"] == {"list": "string"}
    assert schema.field("motion").type.field("jawOpen").type == pa.list_(pa.float32())


def test_a_channel_is_read_alone(exported):
    folder, _ = exported
    file = pq.ParquetFile(folder / "data" / "train-00000-of-00001.parquet")
    rows = file.read(columns=["clip_id", "motion.jawOpen"])
    assert rows.schema.field("motion").type.num_fields == 1


def test_large_parts_are_cut_into_numbered_files_of_the_same_rows(
    divided_once, tmp_path, monkeypatch
):
    monkeypatch.setattr("mimeline.exchange.hugging_face.ROWS", 1)
    monkeypatch.setattr("mimeline.exchange.datasets.MB", 1)
    export(divided_once, "huggingface", tmp_path / "many", Told(), max_mb=1)
    names = sorted(path.name for path in (tmp_path / "many" / "data").glob("train-*"))
    assert names == [f"train-{number:05d}-of-00004.parquet" for number in range(4)]
    export(divided_once, "huggingface", tmp_path / "one", Told(), max_mb=10**9)
    many, one = (pd.read_parquet(tmp_path / name / "data") for name in ("many", "one"))
    assert many["clip_id"].tolist() == one["clip_id"].tolist()


def test_two_exports_are_the_same_to_the_byte(divided_once, tmp_path):
    for name in ("a", "b"):
        export(divided_once, "huggingface", tmp_path / name, Told())
    paths = [p.relative_to(tmp_path / "a") for p in (tmp_path / "a").rglob("*") if p.is_file()]
    assert len(paths) == 5
    for path in paths:
        assert (tmp_path / "a" / path).read_bytes() == (tmp_path / "b" / path).read_bytes()


def test_the_card_tells_the_funnel_the_counts_and_what_is_not_measured(exported):
    folder, _ = exported
    card = (folder / "README.md").read_text()
    assert "| ingest | 7 | 6 | 0 | 1 | could not be read 1 |" in card
    assert "| pose | 6 | 5 | 1 | 0 | the head turns too far 1 |" in card
    assert "| train | 4 | 0.2 | 295 | 4 | 2 |" in card
    assert "| GazeLeft | not known | 0 | 0 |" in card
    assert "Not here (no column &lt;tongue>): `tongueOut`." in card
    assert "| `cheekPuff` | 0.40 | a column |" in card
    about = json.loads((folder / "about.json").read_text())
    for stage in about["funnel"]:
        assert stage["in"] == stage["kept"] + stage["dropped"] + stage["failed"]
    assert about["data_sets"][0]["licence"] == "MIT"
    channels = pd.read_csv(folder / "channels.csv").set_index("channel")
    assert list(channels.index) == list(CHANNELS)
    assert not channels.loc["tongueOut", "exported"]
    having = (90 + 75 + 60 + 50) / (90 + 75 + 60 + 50 + 77)
    assert channels.loc["cheekPuff", "measured"] == pytest.approx(having, rel=1e-5)


@pytest.mark.parametrize(
    ("source", "said"), [("human", "a person (1 of 2 clusters)"), ("proposed", "a rule: no person")]
)
def test_the_card_tells_whether_a_person_named_the_clusters(divided, tmp_path, source, said):
    row = dict.fromkeys(tables.LABELS.schema.names) | {"region": "brow", "action": "BrowUp"}
    row |= {"source": source, "share": 0.5, "unmeasured": []}
    rows = pd.DataFrame([row | {"cluster": 0}, row | {"cluster": 1, "source": "proposed"}])
    results = divided()
    tables.write(tables.LABELS, rows, results / "label" / "labels.parquet")
    export(results, "huggingface", tmp_path / "out", Told())
    assert f"names come from {said}" in (tmp_path / "out" / "README.md").read_text()


def test_the_card_says_where_parts_share_recordings(divided, tmp_path):
    results = divided()
    path = results / "split" / "ledger.parquet"
    noted = tables.read(tables.LEDGER, path).assign(rule="split_by_time")
    tables.write(tables.LEDGER, noted, path)
    export(results, "huggingface", tmp_path / "out", Told())
    assert "**they share recordings and people**" in (tmp_path / "out" / "README.md").read_text()


def test_texts_are_kept_as_they_are_and_a_clip_without_any_has_none(exported):
    folder, _ = exported
    rows = pd.read_parquet(folder / "data").set_index("clip_id")
    assert list(rows.loc["other_0", "texts"]) == ["Élodie\nlooks <up>"]
    assert list(rows.loc["gap_0", "descriptions"]) == ["The person smiles."]
    assert len(rows.loc["mute_0", "texts"]) == len(rows.loc["mute_0", "descriptions"]) == 0
    assert rows.loc["gap_0", "subject_id"] == "p1" and pd.isna(rows.loc["gap_0", "emotion"])


def test_videos_stay_where_they_are(exported):
    folder, _ = exported
    kinds = {path.suffix for path in folder.rglob("*") if path.is_file()}
    assert kinds == {".parquet", ".md", ".json", ".csv"}
    assert "media" not in pq.read_schema(folder / "data" / "train-00000-of-00001.parquet").names


def test_the_hub_hears_how_large_it_is():
    sizes = {0: "n<1K", 999: "n<1K", 1000: "1K<n<10K", 70_000: "10K<n<100K", 10**6: "1M<n<10M"}
    assert {rows: _size(rows) for rows in sizes} == sizes
