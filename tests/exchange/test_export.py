"""`mimeline timeline export`: a run's timelines as files, and the truth that they make."""

from mimeline import tables
from mimeline.annotation.timelines import read_truth
from mimeline.inspection.left_behind import rows_of
from mimeline.timeline import files


def test_exported_timelines_score_the_run_as_the_run_itself(run, finished, tmp_path):
    found = run("export", "--results", finished, "--to", "eaf", "-o", "mine")
    assert (found.code, found.out) == (0, "")
    assert "6 intervals of 3 clips, 1 linked with their video" in found.err
    assert f"evaluate={{truth: {tmp_path / 'mine'}}}" in found.err
    assert "-good_0.mp4" in (tmp_path / "mine" / "-good_0.eaf").read_text()
    clips, ledger = rows_of(finished, "pose", tables.CLIPS), tables.empty(tables.LEDGER)
    truth = read_truth(tmp_path / "mine", clips, ledger)
    assert truth.equals(rows_of(finished, "annotate", tables.FRAMES))


def test_the_command_names_the_folder_as_the_run_finds_it(run, finished, tmp_path):
    (tmp_path / "results").symlink_to(finished)
    for folder, truth in (("mine", "mine"), ("../away", tmp_path.parent / "away")):
        found = run("export", "good_1", "--to", "csv", "-o", folder, "--overwrite")
        assert f"evaluate={{truth: {truth}}}" in found.err


def test_clips_are_asked_for_as_why_takes_them(run, finished, tmp_path):
    for asked, names in (
        (["-good_0"], {"-good_0"}),
        (["good_*", "other"], {"good_1", "other_0"}),
    ):
        folder = f"{len(names)}"
        found = run("export", *asked, "--results", finished, "--to", "vtt", "-o", folder)
        assert found.code == 0
        assert {path.stem for path in (tmp_path / folder).iterdir()} == names
    found = run("export", "good_1", "nobody", "--results", finished, "--to", "vtt", "-o", "some")
    assert found.code == 1 and "clip 'nobody': found no clip of that name" in found.err
    assert (tmp_path / "some" / "good_1.vtt").exists()


def test_a_clip_that_the_run_dropped_has_no_timeline_and_why_tells(run, finished):
    found = run("export", "turned_0", "good_1", "--results", finished, "--to", "csv", "-o", "out")
    assert f"1 clip without a timeline: mimeline why turned_0 --results {finished}" in found.err


def test_where_all_that_is_asked_for_was_dropped_nothing_is_written(run, finished, tmp_path):
    found = run("export", "turned_0", "--results", finished, "--to", "csv", "-o", "out")
    assert found.code == 1 and f"mimeline why turned_0 --results {finished}" in found.err
    assert not (tmp_path / "out").exists()


def test_corrections_are_not_overwritten_unless_that_is_said(run, finished, tmp_path):
    arguments = ("export", "--results", finished, "--to", "eaf", "-o", "mine")
    run(*arguments)
    (tmp_path / "mine" / "good_1.eaf").write_text("corrected")
    found = run(*arguments)
    assert found.code == 1 and "-good_0.eaf and 2 more already" in found.err
    assert (tmp_path / "mine" / "good_1.eaf").read_text() == "corrected"
    assert run(*arguments, "--overwrite").code == 0
    assert files.read(tmp_path / "mine" / "good_1.eaf").clip_id == "good_1"


def test_a_file_is_no_folder_to_export_to(run, finished, tmp_path):
    (tmp_path / "mine").write_text("")
    found = run("export", "--results", finished, "--to", "eaf", "-o", "mine")
    assert found.code == 1 and "mine: found a file, expected a folder" in found.err


def test_where_no_run_has_annotated_the_error_says_what_to_type(run, tmp_path):
    found = run("export", "--results", tmp_path, "--to", "eaf", "-o", "mine")
    assert found.code == 1 and "found no ledger" in found.err
    assert not (tmp_path / "mine").exists()
