"""What `inspect` says of a run's own files, and of takes that a configuration tells how to read."""

import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from mimeline import tables
from mimeline.errors import BadConfig
from mimeline.inspection import inspect, options
from mimeline.inspection.files import TABLES

GOLDEN = Path(__file__).parents[1] / "tracking" / "golden"


def put(take: str, path: Path) -> Path:
    """A copy of a golden take."""
    path.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(GOLDEN / take, path)
    return path


def written(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


@pytest.mark.parametrize("name", TABLES)
def test_every_table_of_a_run_is_told_as_that_and_no_take(tmp_path, name):
    pq.write_table(TABLES[name].schema.empty_table(), tmp_path / "some.parquet")
    assert inspect(tmp_path / "some.parquet", options()).kind == f"table {name}"
    assert inspect(tmp_path, options()).rows[1] == ("some.parquet", f"table {name}")


def test_a_parquet_with_other_columns_is_still_a_take(tmp_path):
    rows = pa.table({"jawOpen": np.linspace(0, 1, 30), "head_yaw_left": np.linspace(0, 0.3, 30)})
    pq.write_table(rows, tmp_path / "take.parquet")
    assert inspect(tmp_path / "take.parquet", options()).numbers["format"] == "table"


@pytest.fixture
def openface(tmp_path) -> Path:
    """A folder with two takes and the losses of one."""
    put("openface/turns_left.csv", tmp_path / "take1.csv")
    put("openface/turns_left.csv", tmp_path / "take2.csv")
    n_frames = len(pd.read_csv(tmp_path / "take1.csv"))
    losses = pd.DataFrame({"frame": np.arange(n_frames), "loss": 0.01})
    losses.to_csv(tmp_path / "take1.loss.csv", index=False)
    return tmp_path


def test_a_sidecar_of_losses_is_no_take(openface):
    for chosen in (options(), options(format="openface")):
        seen = inspect(openface, chosen)
        assert seen.sound and [row[0] for row in seen.rows[1:]] == ["take1.csv", "take2.csv"]
        assert seen.facts["loss sidecars"] == "1"
    seen = inspect(openface / "take1.loss.csv", options())
    assert seen.sound and seen.facts["rows"] == "5"
    written(openface / "take1.loss.csv", "frame,loss\n0,much\n")
    assert "much" in inspect(openface / "take1.loss.csv", options()).error


def test_takes_whose_columns_only_the_configuration_knows_are_found_in_a_folder(tmp_path):
    rows = pd.DataFrame({"my jaw": np.linspace(0, 1, 30), "my yaw": np.linspace(0, 0.3, 30)})
    (tmp_path / "takes").mkdir()
    rows.to_csv(tmp_path / "takes" / "a.csv", index=False)
    table = "{folder: takes, channels: {jawOpen: {column: my jaw}}}"
    here = written(
        tmp_path / "here.yaml",
        f"data_dir: {tmp_path}\ningest: {{format: table, table: {table}}}\n",
    )
    elsewhere = written(tmp_path / "other.yaml", f"ingest: {{format: table, table: {table}}}\n")
    for config in (here, elsewhere):
        seen = inspect(tmp_path / "takes", options(config))
        assert seen.sound and seen.numbers["takes"]["a.csv"]["measured"] == ["jawOpen"]


def test_a_take_of_another_format_fails_as_in_the_run_and_is_told_by_its_own(openface):
    config = written(openface / "mine.yaml", f"data_dir: {openface}\ningest: {{format: openface}}")
    put("livelink/turns_left.csv", openface / "other.csv")
    for path in (openface, openface / "other.csv"):
        seen = inspect(path, options(config))
        (problem,) = [*filter(None, [seen.error]), *seen.problems]
        assert "other.csv" in problem
        assert "like another format, Live Link Face CSV: ingest.format: livelink" in problem
    named = inspect(openface / "other.csv", options(format="openface"))
    assert "ingest.format: livelink" in named.error
    assert inspect(openface / "other.csv", options()).sound


def test_a_run_table_in_another_folder_stays_one_whatever_the_configuration_reads(tmp_path):
    config = written(tmp_path / "mine.yaml", "ingest: {format: table}\n")
    pq.write_table(tables.MOTION.schema.empty_table(), tmp_path / "motion.parquet")
    assert inspect(tmp_path / "motion.parquet", options(config)).kind == "table motion"
    assert ("motion.parquet", "table motion") in inspect(tmp_path, options(config)).rows


def test_what_could_not_be_checked_is_said_and_counted_in_a_folder(tmp_path):
    put("livelink/turns_left.csv", tmp_path / "still.csv")
    seen = inspect(tmp_path / "still.csv", options())
    assert seen.numbers["not_checked"] == ["sides"]
    assert any(note.startswith("not checked: sides (nothing moves") for note in seen.notes)
    put("livelink/turns_left.csv", tmp_path / "other.csv")
    rows = pd.read_csv(GOLDEN / "livelink" / "looks_left.csv")
    rows = pd.concat([rows, rows[::-1]] * 8, ignore_index=True)
    rows["Timecode"] = [f"10:00:{n // 30:02d}:{2 * (n % 30):02d}.0" for n in range(len(rows))]
    swing = np.abs(rows["LeftEyeYaw"])
    rows = rows.assign(EyeLookOutLeft=swing, EyeLookInRight=swing)
    rows.to_csv(tmp_path / "moves.csv", index=False)
    assert inspect(tmp_path / "moves.csv", options()).numbers["not_checked"] == []
    assert "sides not checked in 2 takes" in inspect(tmp_path, options()).notes


def test_the_unit_of_a_gaze_that_nothing_tells_is_not_checked(tmp_path):
    rows = pd.DataFrame({"gaze_left": np.linspace(0, 0.3, 30)})
    rows.to_csv(tmp_path / "take.csv", index=False)
    seen = inspect(tmp_path / "take.csv", options())
    assert seen.numbers["not_checked"] == ["sides", "unit of angles"]


def test_a_key_that_the_format_does_not_have_is_refused_with_those_it_has(openface):
    for chosen in (
        options(sets=["angle_unit=degrees"]),
        options(sets=["angle_unit=degrees"], format="openface"),
        options(sets=["livelink.angle_unit=degrees"], format="openface"),
    ):
        for path in (openface, openface / "take1.csv"):
            with pytest.raises(BadConfig, match="angle_unit.*openface.*one of fps"):
                inspect(path, chosen)
    assert inspect(openface, options(sets=["fps=25", "mirrored=false"])).sound
