import json
import re
import shutil
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.dataset.statistics import statistics
from mimeline.vocabulary import ACTIONS, CHANNELS

PARTS = {"a": "train", "b": "train", "c": "val", "d": "test"}
LENGTH = 100


@pytest.fixture
def results(made, tmp_path, monkeypatch) -> Path:
    """A copy of the results of a sound run."""
    monkeypatch.chdir(tmp_path)  # no config/config.yaml: the defaults
    return Path(shutil.copytree(made, tmp_path / "results"))


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    """The tables of a run of four clips, as training reads them."""
    rng = np.random.default_rng(0)
    n, names = len(PARTS) * LENGTH, list(PARTS)
    keys = {"clip_id": np.repeat(names, LENGTH), "frame": np.tile(np.arange(LENGTH), len(PARTS))}
    values = {name: rng.uniform(0.1, 0.6, n) for name in CHANNELS}
    motion = pd.DataFrame({**keys, "valid": True, "confidence": None, "tracker_loss": None})
    motion = motion.assign(**values)
    frames = pd.DataFrame(keys | {name: rng.random(n) < 0.3 for name in ACTIONS})
    clips = pd.DataFrame({"clip_id": names, "source_id": names, "subject_id": names})
    clips = clips.assign(start_s=0.0, end_s=4.0, fps_num=25, fps_den=1, n_frames=LENGTH, shard=0)
    clips = clips.reindex(columns=tables.CLIPS.schema.names).astype(object)
    for column in ("actions", "emotions", "attributes", "texts"):
        clips[column] = [[] for _ in names]
    clips = clips.where(clips.notna(), None)
    split = pd.DataFrame({"clip_id": names, "part": list(PARTS.values()), "group": names})
    root = tmp_path_factory.mktemp("made")
    for table, rows, where in (
        (tables.CLIPS, clips, "pose/00"),
        (tables.MOTION, motion, "ingest/00"),
        (tables.FRAMES, frames, "annotate/00"),
        (tables.SPLIT, split, "split"),
        (tables.STATISTICS, statistics(motion[motion["clip_id"] < "c"]), "split"),
    ):
        (root / where).mkdir(parents=True, exist_ok=True)
        tables.write(table, rows, root / where / f"{table.name}.parquet")
    return root


@pytest.fixture
def run(mimeline):
    """Runs `mimeline check-data` with arguments: code, out, err."""
    return partial(mimeline, "check-data")


def test_a_sound_run_is_told_within_100_columns(run, results):
    code, said, complaint = run("--results", results)
    assert (code, complaint) == (0, "")
    assert "0 problems and 0 remarks" in said
    assert "1,000 steps of 16 windows of 64 frames" in said
    assert "57 of 57 are learnt" in said and all(action in said for action in ACTIONS)
    assert max(map(len, said.replace(str(results), "results").splitlines())) <= 100
    assert "\x1b" not in said


def test_programs_read_the_same_figures(run, results):
    told = json.loads(run("--results", results, "--json")[1])
    assert told["training"]["window"] == 64 and told["frame_rates"] == {"25": 2}
    assert [part["clips"] for part in told["parts"]] == [2, 1, 1]
    assert len(told["channels"]) == len(CHANNELS) and len(told["actions"]) == 3 * len(ACTIONS)
    assert told["problems"] == told["remarks"] == []


def test_a_problem_ends_with_1_and_a_remark_with_0(run, results):
    path = results / "split" / "split.parquet"
    split = tables.read(tables.SPLIT, path)
    tables.write(tables.SPLIT, split.assign(part=["train", "train", "test", "test"]), path)
    code, said, _ = run("--results", results)
    assert code == 0 and "remarks\n  - no clip in a part, so no validation loss: val\n" in said
    assert "    → split.val, or more sources\n" in said
    tables.write(tables.SPLIT, split.assign(part="test"), path)
    code, said, _ = run("--results", results, "--json")
    assert code == 1 and json.loads(said)["problems"][0]["what"] == "no clip to train on"


def test_the_window_is_that_of_the_configuration(run, results, tmp_path):
    (tmp_path / "mine.yaml").write_text("train: {timeline: {window: 128}}")
    code, said, _ = run("--results", results, "--config", tmp_path / "mine.yaml")
    assert code == 0 and "2 of 2 clips shorter than a window of 128" in " ".join(said.split())
    (tmp_path / "mine.yaml").write_text("train: {timeline: {windows: 128}}")
    code, _, complaint = run("--results", results, "--config", tmp_path / "mine.yaml")
    assert code == 1 and "windows" in complaint and len(complaint.splitlines()) == 1


@pytest.mark.parametrize("stage", ["annotate", "split"])
def test_what_has_not_run_is_told_with_the_command_that_makes_it(run, results, stage):
    for file in (results / stage).rglob("*.parquet"):
        file.unlink()
    code, said, complaint = run("--results", results)
    assert (code, said) == (1, "") and len(complaint.splitlines()) == 1
    assert f"no results of {stage}," in complaint
    assert "snakemake --cores 2 --until annotate split" in complaint


def test_a_folder_that_is_not_there_is_told(run, tmp_path):
    code, _, complaint = run("--results", tmp_path / "nowhere")
    assert code == 1 and "nowhere: found no such folder" in complaint


def test_an_empty_split_tells_its_reason(run, results):
    path = results / "split" / "split.parquet"
    tables.write(tables.SPLIT, tables.empty(tables.SPLIT), path, reason="no clip came through")
    code, _, complaint = run("--results", results)
    assert code == 1 and "no clip: no clip came through" in complaint


def test_a_clip_in_two_parts_is_refused(run, results):
    path = results / "split" / "split.parquet"
    split = tables.read(tables.SPLIT, path)
    twice = pd.concat([split, split[:1].assign(part="val")])
    twice.to_parquet(path)
    code, _, complaint = run("--results", results)
    assert code == 1 and "split.parquet" in complaint and len(complaint.splitlines()) == 1


def test_the_page_names_every_option(run):
    page = (Path(__file__).parents[2] / "docs" / "check_data.md").read_text(encoding="utf-8")
    help = run("--help")[1]
    assert set(re.findall(r"--(?:results|config|json)\b", page)) == set(
        re.findall(r"--\w+", help)
    ) - {"--help"}
