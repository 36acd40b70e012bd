"""A mistake of the user ends in one line that names file, place and remedy."""

import pytest
import yaml

from mimeline import tables


def complaint(done) -> str:
    """The one line of mimeline's in what a failed run printed."""
    assert done.returncode != 0
    text = done.stdout + done.stderr
    assert "Traceback" not in text, text
    lines = [
        line for line in text.splitlines() if line.startswith("mimeline: ") and "found" in line
    ]
    assert len(lines) == 1, text
    return lines[0]


def test_a_missing_data_dir(checkout):
    line = complaint(checkout.run("-n", "--config", "data_dir=nowhere", config=()))
    assert "nowhere: found no such folder" in line
    assert "Correct data_dir" in line


def test_a_file_is_no_data_dir(checkout):
    line = complaint(checkout.run("-n", "--config", "data_dir=Snakefile", config=()))
    assert "Snakefile: found no such folder" in line


def test_a_label_file_that_is_not_there(checkout):
    line = complaint(checkout.run("-n", "--config", "label={file: nope.yaml}", config=()))
    assert "nope.yaml: found no such file" in line
    assert "label.file" in line


def test_a_face_model_that_is_not_there(checkout, tmp_path):
    change = ("ingest={format: flame, flame: {face: nope.npz}}", f"data_dir={tmp_path}")
    line = complaint(checkout.run("-n", "--config", *change, config=()))
    assert "nope.npz: found no such file" in line
    assert "ingest.flame.face" in line


def test_exclusions_without_their_columns_and_a_condition_on_no_column(checkout, tmp_path):
    path = tmp_path / "out.csv"
    path.write_text("id,why\n")
    line = complaint(checkout.run("-n", "--config", f"select={{exclusions: {path}}}", config=()))
    assert "out.csv: found columns id, why, expected clip_id, reason" in line
    change = "select={conditions: [widht > 3]}"
    line = complaint(checkout.run("-n", "--config", change, config=()))
    assert "found widht, which is no column" in line


def test_an_unknown_key(checkout):
    line = complaint(checkout.run("-n", "--config", "segmnt={}", config=()))
    assert "key segmnt: found an unknown key" in line


TABLE = "results/label/labels.parquet"


@pytest.fixture(scope="module")
def relabelled(toy_run, tmp_path_factory):
    """Name the clusters of the finished run by a label file, the proposed one changed for brow.

    change → the run, and the label file's path. In the end the clusters are named as they were.
    """
    folder = tmp_path_factory.mktemp("labels")
    written = (toy_run.root / "results/label/labels.yaml").read_text()

    def relabelled(change: dict):
        names = yaml.safe_load(written)
        names["brow"] |= change
        labels, config = folder / "names.yaml", folder / "config.yaml"
        labels.write_text(yaml.safe_dump(names))
        config.write_text(yaml.safe_dump({"label": {"file": str(labels)}}))
        return toy_run.run(TABLE, config=("tests/workflow/tiny.yaml", str(config))), labels

    yield relabelled
    again = toy_run.run(TABLE)
    assert again.returncode == 0, again.stderr


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"clusters": {0: "EyebrowUp"}}, "region brow, cluster 0: found 'EyebrowUp'"),
        ({"clusters": {0: {"same_as": 0}}}, "region brow, cluster 0: found cluster 0, which is"),
        ({"clusters": [1, 2]}, "region brow, clusters: found ['1', '2']"),
    ],
)
def test_a_label_file_that_does_not_fit_stops_the_run(relabelled, change, message):
    done, labels = relabelled(change)
    line = complaint(done)
    assert message in line
    assert str(labels) in line


def test_names_of_a_fit_that_nobody_knows_stop_the_run_with_the_command_that_mends_it(relabelled):
    done, labels = relabelled({"model": "0123456789abcdef"})
    line = complaint(done)
    assert "region brow: found clusters that no name of model 0123456789abcdef" in line
    assert line.endswith(f"mimeline label --results results --file {labels}")


def test_a_label_file_that_fits_names_the_clusters(toy_run, relabelled):
    done, _ = relabelled({"clusters": {0: {"action": "BrowUp", "note": "strong"}}})
    assert done.returncode == 0, done.stderr
    table = tables.read(tables.LABELS, toy_run.root / TABLE)
    row = table[(table["region"] == "brow") & (table["cluster"] == 0)].iloc[0]
    assert row[["action", "note", "source"]].tolist() == ["BrowUp", "strong", "human"]


def test_a_run_that_loses_every_clip_ends_with_a_report_that_says_so(clipless_run):
    root, said = clipless_run
    page = (root / "results/report/index.html").read_text(encoding="utf-8")
    assert "No clip came through" in page
    assert "the report is results/report/index.html" in said
