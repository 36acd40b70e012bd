import errno
from pathlib import Path
from types import SimpleNamespace

import pytest

from mimeline.errors import BadFile
from mimeline.vocabulary import resource
from mimeline.workflow import (
    chosen,
    code_digest,
    listing,
    resource_table,
    settle_config,
    stage,
)


class Outputs(dict):
    """Named outputs as snakemake gives them."""


@pytest.fixture
def job(tmp_path):
    output = Outputs(
        table=str(tmp_path / "out" / "t.txt"), many=[str(tmp_path / "a"), str(tmp_path / "b")]
    )
    return SimpleNamespace(
        input={}, output=output, params={}, wildcards={}, threads=1, log=[str(tmp_path / "log")]
    )


def test_outputs_appear_whole_when_the_stage_ends_well(job, tmp_path):
    with stage(job) as inner:
        inner.output.table.write_text("whole")
        for path in inner.output.many:
            path.mkdir()
        assert not (tmp_path / "out" / "t.txt").exists()
    assert (tmp_path / "out" / "t.txt").read_text() == "whole"
    assert (tmp_path / "a").is_dir()


def test_a_failed_stage_leaves_neither_output_nor_traceback_for_a_users_mistake(
    job, tmp_path, capfd
):
    with pytest.raises(SystemExit), stage(job) as inner:
        inner.output.table.write_text("half")
        raise BadFile("x.csv", found="a", expected="b", remedy="Mend it.")
    assert sorted(p.name for p in tmp_path.rglob("*") if p.is_file()) == ["log"]
    shown = capfd.readouterr().err
    assert "mimeline: x.csv: found a, expected b. Mend it." in shown
    assert "Traceback" not in shown


def test_an_error_of_ours_keeps_its_traceback(job, capfd):
    with pytest.raises(SystemExit), stage(job):
        raise RuntimeError("a slip")
    assert "a slip" in capfd.readouterr().err


def test_a_full_disk_is_no_error_of_ours(job, capfd):
    with pytest.raises(SystemExit), stage(job):
        raise OSError(errno.ENOSPC, "No space left on device")
    shown = capfd.readouterr().err
    assert "found no space left on its disk" in shown
    assert "Traceback" not in shown


def test_an_old_output_stays_until_the_new_one_is_whole(job, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "t.txt").write_text("old")
    with pytest.raises(SystemExit), stage(job):
        raise RuntimeError("a slip")
    assert (tmp_path / "out" / "t.txt").read_text() == "old"


def test_a_digest_follows_imports_and_differs_between_stages():
    assert code_digest("mimeline.clips.select") != code_digest("mimeline.clips.pose")
    assert code_digest("mimeline.clips.select") == code_digest("mimeline.clips.select")


def test_only_the_chosen_format_is_handed_on():
    section = {"format": "a", "a": {"x": 1}, "b": {"y": 2}}
    assert chosen(section) == {"format": "a", "options": {"x": 1}}


@pytest.mark.parametrize("name", ["", "all.csv"])
def test_a_truth_may_be_a_folder_or_a_file(tmp_path: Path, name):
    (tmp_path / "all.csv").write_text("")
    truth = str(tmp_path / name)
    assert settle_config({"evaluate": {"truth": truth}})["evaluate"]["truth"] == truth


def test_a_truth_that_is_not_there_ends_with_one_line(tmp_path: Path):
    with pytest.raises(SystemExit, match="nowhere: found no such file or folder"):
        settle_config({"evaluate": {"truth": str(tmp_path / "nowhere")}})


def test_a_listing_follows_names_sizes_and_times(tmp_path: Path):
    empty = listing(str(tmp_path))
    (tmp_path / "x").write_text("1")
    one = listing(str(tmp_path))
    (tmp_path / "x").write_text("22")
    assert len({empty, one, listing(str(tmp_path))}) == 3
    assert listing(None) == "made on the way"


def test_a_listing_of_a_single_file_follows_its_size_and_time(tmp_path: Path):
    file = tmp_path / "face.npz"
    file.write_bytes(b"one")
    one = listing(str(file))
    file.write_bytes(b"longer")
    assert listing(str(file)) != one


def test_a_static_table_is_told_from_the_checkout_on_so_that_it_can_be_moved(tmp_path, monkeypatch):
    table = resource("proposals.csv")
    monkeypatch.chdir(table.parents[1])
    assert resource_table("proposals.csv") == "resources/proposals.csv"
    monkeypatch.chdir(tmp_path)
    assert resource_table("proposals.csv") == str(table)
