"""`mimeline dataset export`: which runs it takes, and which folders."""

import re
import shutil

import numpy
import pytest

from mimeline import tables


@pytest.fixture
def run(mimeline, monkeypatch, tmp_path):
    """Runs an export into a folder of its own: code, out, err."""
    monkeypatch.chdir(tmp_path)

    def ask(results, folder, *words, to="huggingface"):
        return mimeline("dataset", "export", "--results", results, "--to", to, "-o", folder, *words)

    return ask


def files(folder) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def names(folder) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_it_says_what_was_written_and_how_to_load_it(run, divided, tmp_path):
    found = run(divided(), "out")
    assert (found.code, found.out) == (0, "")
    assert re.match(r"wrote out \(huggingface\): 5 clips, 0\.2 minutes, \d+ kB: train 4", found.err)
    assert f"clips = load_dataset({str(tmp_path / 'out')!r})" in found.err
    found = run(tmp_path / "results", "arrays", to="humanml3d")
    lines = [line.strip() for line in found.err.partition("to load it:\n")[2].splitlines()]
    space = {"numpy": numpy}
    exec("\n".join(lines), space)
    assert space["motion"].shape[1] == len(space["channels"])


def test_an_export_is_replaced_only_where_that_is_said(run, divided, tmp_path):
    results = divided()
    run(results, "out")
    (tmp_path / "out" / "README.md").write_text("filled in")
    found = run(results, "out")
    assert found.code == 1 and "found an export already" in found.err and "--overwrite" in found.err
    assert (tmp_path / "out" / "README.md").read_text() == "filled in"
    assert run(results, "out", "--overwrite").code == 0
    assert (tmp_path / "out" / "README.md").read_text() != "filled in"


def test_a_folder_with_anything_else_in_it_stays_whatever_is_said(run, divided, tmp_path):
    results, mine = divided(), tmp_path / "mine"
    mine.mkdir()
    (mine / "thesis.tex").write_text("mine")
    found = run(results, "mine", "--overwrite")
    assert found.code == 1 and "found a folder with something else in it" in found.err
    assert files(mine) == {"thesis.tex": b"mine"}
    run(results, "hub")
    (tmp_path / "hub" / ".git").mkdir()
    found = run(results, "hub", "--overwrite")
    assert found.code == 1 and "an export with .git in it" in found.err
    (tmp_path / "file").write_text("")
    assert "found a file" in run(results, "file", "--overwrite").err


def test_an_empty_folder_is_taken(run, divided, tmp_path):
    (tmp_path / "out").mkdir()
    assert run(divided(), "out").code == 0


def test_where_it_fails_half_way_what_was_there_stays(run, divided, tmp_path):
    results = divided()
    run(results, "out")
    before = files(tmp_path / "out")
    path = results / "annotate" / "01" / "frames.parquet"
    frames = tables.read(tables.FRAMES, path)
    tables.write(tables.FRAMES, frames.iloc[1:], path)
    found = run(results, "out", "--overwrite")
    assert found.code == 1 and "other frames than those of the motion" in found.err
    assert files(tmp_path / "out") == before
    assert names(tmp_path) == ["out", "results"]


@pytest.mark.parametrize(("gone", "found"), [("split", "no split"), ("annotate", "no timelines")])
def test_a_run_that_has_not_come_so_far_hears_what_to_type(run, divided, tmp_path, gone, found):
    results = divided()
    shutil.rmtree(results / gone)
    said = run(results, "out")
    assert said.code == 1 and f"found {found}" in said.err
    assert "snakemake --cores 2 --until describe split" in said.err
    assert not (tmp_path / "out").exists()


def test_where_no_run_has_been_the_error_says_so(run, tmp_path):
    found = run(tmp_path / "nothing", "out")
    assert found.code == 1 and "found no such folder" in found.err


def test_tables_of_two_runs_are_refused(run, divided, tmp_path):
    results = divided()
    path = results / "split" / "split.parquet"
    parts = tables.read(tables.SPLIT, path)
    tables.write(tables.SPLIT, parts.iloc[1:], path)
    found = run(results, "out")
    assert found.code == 1 and "stage split" in found.err
    path = results / "ingest" / "00" / "motion.parquet"
    shutil.copytree(tmp_path / "results", tmp_path / "other")
    tables.write(tables.SPLIT, parts, tmp_path / "other" / "split" / "split.parquet")
    path = tmp_path / "other" / "ingest" / "00" / "clips.parquet"
    clips = tables.read(tables.CLIPS, path)
    tables.write(tables.CLIPS, clips.iloc[1:], path)
    found = run(tmp_path / "other", "out")
    assert found.code == 1 and "no motion of clip '-good_0'" in found.err


def test_a_shard_without_a_clip_is_passed_over(run, divided, tmp_path):
    results = divided()
    for path in sorted(results.glob("*/01/*.parquet")):
        last = path.parents[1] / "02" / path.name
        last.parent.mkdir(exist_ok=True)
        path.rename(last)
        table = next(t for t in vars(tables).values() if getattr(t, "name", "") == path.stem)
        tables.write(table, tables.empty(table), path)
    found = run(results, "out")
    assert found.code == 0 and "5 clips" in found.err


@pytest.mark.parametrize("hostile", ["../../evil", "a/b", "", ".hidden", "x\n"])
def test_an_id_that_is_no_file_name_is_refused(run, divided, tmp_path, hostile):
    results = divided()
    known = {own.name: own for own in vars(tables).values() if isinstance(own, tables.Table)}
    for path in results.rglob("*.parquet"):
        rows = tables.read(table := known[path.stem], path)
        if "clip_id" in rows and (rows["clip_id"] == "good_1").any():
            rows["clip_id"] = rows["clip_id"].replace("good_1", hostile)
            tables.write(table, rows, path)
    for to in ("huggingface", "humanml3d"):
        found = run(results, "out", to=to)
        assert found.code == 1 and "an id that is no plain file name" in found.err
    assert names(tmp_path) == ["results"]


def test_a_frame_rate_has_no_place_where_each_clip_keeps_its_own(run, divided):
    found = run(divided(), "out", "--fps", "20")
    assert found.code == 1 and "--fps: found a frame rate with --to huggingface" in found.err
