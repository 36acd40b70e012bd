import json
import shutil
from pathlib import Path

import pytest
import yaml

from mimeline import tables
from mimeline.config import validate
from mimeline.errors import MimelineError, NoSuchFile
from mimeline.inspection.funnel import as_json, as_text, funnel
from mimeline.run import remember

from .conftest import OPTIONS


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch) -> None:
    """No config/config.yaml but the one that a test writes."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def own(tmp_path) -> Path:
    """The run's own configuration."""
    path = tmp_path / "own.yaml"
    path.write_text(yaml.safe_dump({"select": OPTIONS, "pose": {"format": "motion"}}))
    return path


def files(folder: Path) -> dict[Path, float]:
    return {path: path.stat().st_mtime_ns for path in folder.rglob("*")}


def test_the_stages_have_what_came_in_and_every_reason(run_results):
    found = funnel(run_results, [], [])
    numbers = {s.name: (s.entered, s.kept, s.dropped, s.failed) for s in found.funnel.stages}
    assert numbers == {
        "catalogue": (10, 9, 0, 1),
        "select": (9, 4, 5, 0),
        "fetch": (4, 3, 0, 1),
        "ingest": (3, 3, 0, 0),
        "pose": (3, 2, 1, 0),
    }
    text = as_text(found)
    assert "10 clips in, 2 left after pose" in text and "not run yet: split" in text
    assert "too long 1" in text and "was not applied" in text
    assert json.loads(as_json(found))["stages"][1]["in"] == 9


def test_results_that_do_not_agree_are_told_up_to_there(run_results, tmp_path):
    results = tmp_path / "results"
    shutil.copytree(run_results, results)
    path = results / "fetch" / "00" / "ledger.parquet"
    rows = tables.read(tables.LEDGER, path)
    tables.write(tables.LEDGER, rows[rows["clip_id"] != "good_0"], path)
    found = funnel(results, [], [])
    assert [stage.name for stage in found.funnel.stages] == ["catalogue", "select"]
    assert "clip 'good_0', which has no decision" in found.problem
    assert "problems" in as_text(found)


def test_clips_that_a_table_lacks_are_told(run_results, tmp_path):
    results = tmp_path / "results"
    shutil.copytree(run_results, results)
    path = results / "pose" / "00" / "clips.parquet"
    tables.write(tables.CLIPS, tables.read(tables.CLIPS, path).iloc[1:], path)
    assert "amiss" in funnel(results, [], []).problem


def test_a_longer_limit_gains_clips_and_says_what_nobody_knows_of_them(run_results, own):
    before = files(run_results)
    found = funnel(run_results, [own], ["select.max_s=13"])
    (change,) = found.changes
    assert change.gained == ["-long"] and not change.lost and change.kept == 5
    assert change.reasons.get("too_long", 0) == 0 and found.now["select"].reasons["too_long"] == 1
    text = as_text(found)
    assert "too long 1 → 0" in text and "+1" in text
    assert "fetch, ingest and pose never saw them" in text
    assert not found.differ["select"] and files(run_results) == before


def test_a_shorter_limit_loses_clips_that_had_come_through(run_results, own):
    (change,) = funnel(run_results, [own], ["select.max_s=8"]).changes
    assert change.lost == ["good_1"] and change.through == 1 and change.kept == 3
    assert change.seconds == pytest.approx(18.0)


def test_several_values_have_a_line_each_beside_the_run_s_own(run_results, own):
    found = funnel(run_results, [own], ["select.max_s=8,13,6", "select.min_s=3"])
    assert [change.kept for change in found.changes] == [4, 6, 4]
    lines = as_text(found).splitlines()
    assert lines[0].split()[:2] == ["select.max_s", "select.min_s"]
    numbers = [line.split()[1:3] for line in lines[1:]]
    assert numbers == [["6", "3"], ["8", "3"], ["10", "5"], ["13", "3"]]
    assert lines[3].endswith("now")


def test_a_key_that_is_asked_twice_has_two_values(run_results, own):
    wishes = ["'turn' in actions", "emotion == 'happy'"]
    found = funnel(run_results, [own], [f"select.conditions={wish}" for wish in wishes])
    assert [change.asked["select.conditions"] for change in found.changes] == [[w] for w in wishes]
    assert all(wish in as_text(found) for wish in wishes)


def test_another_yaw_is_asked_of_the_frames_themselves(run_results, own):
    found = funnel(run_results, [own], ["pose.max_yaw_deg=20,35,42"])
    assert [change.kept for change in found.changes] == [1, 2, 3]
    assert [change.is_now for change in found.changes] == [False, True, False]
    assert found.changes[0].lost == ["good_1"] and found.changes[2].gained == ["looks_away"]


@pytest.mark.parametrize(
    ("asked", "kept"),
    [
        ("select.excluded_actions=", 5),
        ("select.excluded_actions=turn, nod", 4),
        ("select.excluded_actions=[nod]", 5),
        ("select.conditions=emotion == 'sad'", 3),
        ("select.conditions=[emotion is not None, duration_s < 7]", 1),
        ("select.max_overlap=null", 5),
        ("select.min_side_px=300", 5),
        ("select.exclusions=list.csv", 3),
    ],
)
def test_every_rule_of_select_can_be_asked(run_results, own, tmp_path, asked, kept):
    (tmp_path / "list.csv").write_text("clip_id,reason\ngood_0,occlusion\n")
    (change,) = funnel(run_results, [own], [asked]).changes
    assert change.kept == kept
    assert change.kept + sum(change.reasons.values()) == 9


def test_two_stages_are_asked_each_for_itself(run_results, own):
    found = funnel(run_results, [own], ["pose.max_yaw_deg=42", "select.max_s=13"])
    assert [(change.stage, change.kept) for change in found.changes] == [("select", 5), ("pose", 3)]


def test_results_of_other_options_are_called_that(run_results, own, tmp_path):
    other = tmp_path / "other.yaml"
    other.write_text("select: {min_s: 2}")
    found = funnel(run_results, [own, other], ["select.max_s=13"])
    assert found.differ["select"] == ["short"]
    text = " ".join(as_text(found).split())
    assert "The ledger of select says otherwise of 1 clip, such as short" in text


def test_the_checkout_s_own_configuration_counts_where_none_is_named(run_results, own, tmp_path):
    (tmp_path / "config").mkdir()
    own.rename(tmp_path / "config" / "config.yaml")
    assert not funnel(run_results, [], ["select.max_s=13"]).differ["select"]
    assert funnel(run_results, [], ["select.max_s=13"]).changes[0].kept == 5


def test_what_the_run_was_told_counts_where_no_configuration_is_named(run_results, tmp_path):
    results = shutil.copytree(run_results, tmp_path / "results")
    config = validate({"select": OPTIONS | {"max_s": 14.0}, "pose": {"format": "motion"}})
    remember(results, config, [], ["select={max_s: 14}"])
    found = funnel(results, [], ["select.max_s=13"])
    assert found.now["select"].asked == {"select.max_s": 14.0}
    assert found.differ["select"] == ["-long"]
    text = " ".join(as_text(found).split())
    assert "Type snakemake --cores 2 --config 'select={max_s: 14}' first." in text


@pytest.mark.parametrize(("folder", "told"), [(None, "no data_dir"), ("gone", "no such file")])
def test_head_poses_that_are_not_there_are_asked_for(run_results, tmp_path, folder, told):
    own = tmp_path / "own.yaml"
    own.write_text(
        yaml.safe_dump({"data_dir": folder, "select": OPTIONS, "pose": {"format": "sixdrepnet"}})
    )
    with pytest.raises(NoSuchFile, match="--config") as error:
        funnel(run_results, [own], ["pose.max_yaw_deg=20"])
    assert told in str(error.value) and "toy" not in str(error.value)


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        (["ingest.max_missing=0.5"], "a key that cannot be asked, expected one of select.min_s"),
        (["select.maxs=12"], "Is it select.max_s?"),
        (["select.max_s"], "no KEY=VALUE"),
        (["select.max_s=fast"], "key select.max_s: found 'fast'"),
        (["select.max_s=4"], "select.min_s to be at most select.max_s"),
        (["select.max_s=8,9", "select.min_s=1,2"], "several values of both"),
        (["select.conditions=emoton == 'x'"], "emoton, which is no column"),
        (["select.exclusions=none.csv"], "none.csv: found no such file"),
    ],
)
def test_what_cannot_be_asked_says_what_can(run_results, own, asked, told):
    with pytest.raises(MimelineError) as error:
        funnel(run_results, [own], asked)
    assert told in str(error.value)


def test_a_stage_that_nobody_ran_cannot_be_asked(run_results, own, tmp_path):
    shutil.copytree(run_results / "catalogue", tmp_path / "results" / "catalogue")
    with pytest.raises(NoSuchFile, match="--until ingest"):
        funnel(tmp_path / "results", [own], ["pose.max_yaw_deg=20"])
    found = funnel(tmp_path / "results", [own], ["select.max_s=13"])
    assert found.changes[0].kept == 5 and not found.differ["select"]


def test_where_no_run_has_been_the_funnel_says_so(run_results, tmp_path, own):
    with pytest.raises(NoSuchFile, match="Run snakemake first"):
        funnel(tmp_path / "nowhere", [own], [])
    with pytest.raises(NoSuchFile, match="a configuration in YAML"):
        funnel(run_results, [tmp_path / "none.yaml"], ["select.max_s=13"])
