"""`mimeline timeline`: convert, diff, merge, lint."""

import json
import os
import re
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest

from mimeline.timeline import files
from mimeline.timeline.timeline import Interval, Timeline

NTSC = Fraction(30000, 1001)
SMILES = [Interval("Smile", 10, 50, None, "ticc", 3, 0.9), Interval("SoftSmile", 60, 80)]
BROW = [Interval("BrowUp", 0, 20, "left")]


@pytest.fixture
def clip(tmp_path):
    """A timeline, and where to write changed ones."""
    timeline = Timeline("clip", NTSC, 90, {"brow": BROW, "closure": [], "mouth": SMILES})

    def written(name, **changed):
        files.write(replace(timeline, **changed), tmp_path / name)
        return timeline

    return written


def test_convert_says_in_a_line_what_it_wrote_and_what_is_not_kept(run, clip):
    clip("clip.json")
    found = run("convert", "clip.json", "clip.eaf")
    assert (found.code, found.out) == (0, "")
    assert found.err == (
        "wrote clip.eaf (elan): 3 intervals on 3 tracks; not kept: source, cluster, confidence\n"
    )
    found = run("convert", "clip.json", "clip.csv")
    assert "to read it again: --fps 30000/1001 --frames 90" in found.err


@pytest.mark.parametrize("name", ["clip.csv", "clip.eaf", "clip.vtt", "clip.TextGrid", "clip.txt"])
def test_with_what_convert_said_a_file_is_read_as_it_was(run, clip, name):
    clip("clip.json", tracks={"brow": BROW, "mouth": SMILES})
    said = run("convert", "clip.json", name).err.partition("to read it again: ")[2].split()
    assert run("convert", name, "back.json", "--clip", "clip", *said).code == 0
    found = run("diff", "clip.json", "back.json")
    assert (found.code, found.err) == (0, "")


@pytest.mark.parametrize(
    ("spoken", "meant"),
    [("23.976", "24000/1001"), ("29.97", "30000/1001"), ("59.94", "60000/1001")],
)
def test_a_rate_in_decimals_means_the_exact_one_and_says_so(run, clip, tmp_path, spoken, meant):
    clip("clip.TextGrid", fps=Fraction(meant))
    found = run("convert", "clip.TextGrid", "out.json", "--fps", spoken)
    assert found.err.startswith(f"{spoken} frames per second are {meant}\n")
    assert files.read(tmp_path / "out.json").fps == Fraction(meant)


@pytest.mark.parametrize("text", ["fast", "0", "30/0", "-25", "1e3"])
def test_what_is_no_rate_ends_with_one_line(run, clip, text):
    clip("clip.TextGrid")
    found = run("convert", "clip.TextGrid", "out.json", f"--fps={text}")
    assert found.code == 1 and found.err.startswith("mimeline: --fps: found")
    assert len(found.err.splitlines()) == 1


@pytest.mark.parametrize("option", ["--fps=25", "--frames=91"])
def test_what_is_said_and_the_file_tells_otherwise_is_an_error(run, clip, tmp_path, option):
    clip("clip.json")
    found = run("convert", "clip.json", "out.eaf", option)
    assert found.code == 1 and "as you said" in found.err
    assert not (tmp_path / "out.eaf").exists()


def test_no_clip_has_less_than_a_frame(run, tmp_path):
    (tmp_path / "none.txt").write_text("")
    found = run("convert", "none.txt", "out.json", "--fps", "25", "--frames", "-4")
    assert found.code == 1 and found.err.startswith("mimeline: --frames: found -4")


def test_a_file_is_never_written_over_the_one_that_it_is_made_from(run, clip, tmp_path):
    clip("clip.eaf")
    clip("other.eaf", tracks={})
    (tmp_path / "link.eaf").symlink_to("clip.eaf")
    before = (tmp_path / "clip.eaf").read_bytes()
    for arguments in (
        ("convert", "clip.eaf", "clip.eaf"),
        ("convert", "clip.eaf", "./link.eaf"),
        ("convert", "clip.eaf", "clip.eaf", "--overwrite"),
        ("convert", "clip.eaf", ".", "--to", "eaf"),
        ("convert", "clip.eaf", ".", "--to", "eaf", "--overwrite"),
        ("merge", "other.eaf", "clip.eaf", "-o", "clip.eaf"),
        ("merge", "clip.eaf", "other.eaf", "-o", "clip.eaf"),
    ):
        found = run(*arguments)
        assert found.code == 1 and "found" in found.err
        assert (tmp_path / "clip.eaf").read_bytes() == before


def test_a_format_is_named_by_its_ending_too(run, clip, tmp_path):
    clip("clip.json")
    for name in ("eaf", ".EAF", "elan"):
        assert run("convert", "clip.json", "clip.elan", "--to", name, "--overwrite").code == 0
        assert run("diff", "clip.elan", "clip.elan", "--from", name).code == 0
    found = run("convert", "clip.json", "clip.foo", "--to", "foo")
    assert found.code == 1 and "There are json, csv, webvtt, elan, praat, stmc." in found.err


def test_a_file_that_is_there_stays_unless_it_is_said(run, clip, tmp_path):
    clip("a.json")
    clip("b.json")
    for arguments in (
        ("convert", "a.json", "out.eaf"),
        ("merge", "a.json", "b.json", "-o", "m.vtt"),
    ):
        path = tmp_path / arguments[-1]
        path.write_text("corrected")
        found = run(*arguments)
        assert found.code == 1 and "found a file already" in found.err
        assert "--overwrite" in found.err and path.read_text() == "corrected"
        assert run(*arguments, "--overwrite").code == 0
        assert files.read(path).clip_id == "clip"


@pytest.mark.parametrize("target", ["folder.eaf", "pipe", "link.eaf"])
def test_what_is_no_file_is_not_written_to(run, clip, tmp_path, target):
    clip("a.json")
    (tmp_path / "folder.eaf").mkdir()
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link.eaf").symlink_to("linked.eaf")
    clip("linked.eaf")
    found = run("merge", "a.json", "a.json", "-o", target, "--to", "eaf", "--overwrite")
    assert found.code == 1 and "Name a file." in found.err
    assert (tmp_path / "pipe").is_fifo() and (tmp_path / "link.eaf").is_symlink()


def test_a_folder_is_made_where_the_name_has_no_ending(run, clip, tmp_path):
    clip("a.json")
    assert run("convert", "a.json", "new/out", "--to", "eaf").code == 0
    assert files.read(tmp_path / "new" / "out" / "clip.eaf").clip_id == "clip"
    found = run("convert", "a.json", "other")
    assert found.code == 1 and "Say it, as --to eaf." in found.err


def test_a_folder_is_read_by_convert_alone(run, clip, tmp_path):
    (tmp_path / "mine").mkdir()
    clip("a.json")
    for arguments in (("diff", "a.json", "mine"), ("lint", "mine")):
        found = run(*arguments)
        assert found.code and "found a folder" in found.out + found.err
        assert "mine/*" in found.out + found.err


def test_a_folder_is_converted_file_by_file(run, clip, tmp_path):
    for name in ("a", "b"):
        clip(f"mine/{name}.eaf", clip_id=name)
    assert "of 2 clips" in run("convert", "mine", "out", "--to", "json").err
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"a.json", "b.json"}
    found = run("convert", "mine", "mine", "--to", "eaf", "--overwrite")
    assert found.code == 1 and "the file that is read" in found.err
    assert "leave --clip out" in run("convert", "mine", "c.csv", "--clip", "a").err
    clip("mine/c.vtt", clip_id="a")
    found = run("convert", "mine", "all.csv")
    assert found.code == 1 and "clip a: found a clip that is in mine/a.eaf too" in found.err
    (tmp_path / "empty").mkdir()
    assert "no file of timelines" in run("convert", "empty", "all.csv").err


def test_a_file_of_several_clips_goes_to_a_folder_or_one_of_them_to_a_file(run, clip, tmp_path):
    whole = clip("clip.json")
    names = ["clip", "clip2"]
    files.write_all([replace(whole, clip_id=name) for name in names], tmp_path / "all.json")
    (tmp_path / "out").mkdir()
    assert "2 clips" in run("convert", "all.json", "out", "--to", "TextGrid").err
    assert {p.name for p in (tmp_path / "out").iterdir()} == {"clip.TextGrid", "clip2.TextGrid"}
    assert run("convert", "all.json", "one.eaf", "--clip", "clip2").code == 0
    assert files.read(tmp_path / "one.eaf").clip_id == "clip2"
    assert "--clip clip." in run("diff", "all.json", "one.eaf").err
    assert run("diff", "all.json", "one.eaf", "--clip", "clip2").code == 0
    assert run("convert", "all.json", "two.eaf").code == 1
    assert "Say it, as --to eaf." in run("convert", "all.json", "out").err


def test_a_video_is_linked_where_it_is_there(run, clip, tmp_path):
    clip("clip.json")
    found = run("convert", "clip.json", "clip.eaf", "--media", "clip.mp4")
    assert found.code == 1 and "clip.mp4: found no such file" in found.err
    (tmp_path / "clip.mp4").write_bytes(b"")
    assert run("convert", "clip.json", "clip.eaf", "--media", "clip.mp4").code == 0
    assert 'RELATIVE_MEDIA_URL="./clip.mp4"' in (tmp_path / "clip.eaf").read_text()
    arguments = ("merge", "clip.json", "clip.json", "-o", "both.eaf", "--media")
    assert "no.mp4: found no such file" in run(*arguments, "no.mp4").err
    assert run(*arguments, "clip.mp4").code == 0
    assert 'RELATIVE_MEDIA_URL="./clip.mp4"' in (tmp_path / "both.eaf").read_text()
    assert "media" in run("convert", "clip.json", "clip.csv", "--media", "clip.mp4").err


def test_an_id_that_leads_out_of_the_folder_is_refused(run, clip, tmp_path):
    clip("hostile.json", clip_id="../away")
    (tmp_path / "out").mkdir()
    found = run("convert", "hostile.json", "out", "--to", "json")
    assert found.code == 1 and "'../away'" in found.err
    assert not (tmp_path / "away.json").exists()


def test_diff_tells_track_by_track_with_frames_seconds_and_agreement(run, clip):
    clip("a.json")
    moved = [replace(SMILES[0], start=12, end=47), replace(SMILES[1], action="MouthFrown")]
    clip("b.eaf", tracks={"mouth": moved, "closure": [], "lid": []})
    found = run("diff", "a.json", "b.eaf")
    assert (found.code, found.err) == (1, "")
    lines = found.out.splitlines()
    assert lines[0] == (
        "clip: 2 differences, 2 tracks in one of them only (90 frames at 30000/1001 fps, 3.00 s)"
    )
    assert lines[1:3] == ["  - a.json", "  + b.eaf"]
    assert "mouth  72 % of frames agree" in found.out
    assert "10 to 50  0.33 to 1.67 s  starts 2 frames later, ends 3 frames earlier" in found.out
    assert "! SoftSmile → MouthFrown" in found.out
    assert lines[-3:] == [
        "the same: closure",
        "measured only in a.json: brow",
        "measured only in b.eaf: lid",
    ]


def test_diff_ends_as_diff_does(run, clip):
    clip("a.json")
    clip("b.json", tracks={"mouth": []})
    assert [run("diff", "a.json", name).code for name in ("a.json", "b.json", "none.json")] == [
        0,
        1,
        2,
    ]


def test_diff_tells_programs_the_same(run, clip):
    clip("a.json")
    clip("b.json", tracks={"mouth": SMILES[:1], "brow": BROW, "closure": []})
    told = json.loads(run("diff", "a.json", "b.json", "--json").out)
    assert (told["same"], told["fps"], told["n_frames"]) == (False, "30000/1001", 90)
    (change,) = told["changes"]
    assert (change["track"], change["kind"], change["b"]) == ("mouth", "only in a", None)
    assert change["a"]["start"] == 60
    assert told["agreement"]["brow"] == {"share": 1.0, "kappa": 1.0}


def test_what_one_file_does_not_tell_the_other_does(run, clip):
    clip("a.json")
    clip("bob.TextGrid")
    assert run("diff", "a.json", "bob.TextGrid").code == 0
    assert run("merge", "bob.TextGrid", "a.json", "-o", "both.json").code == 0


def test_merge_asks_who_is_right_and_then_writes(run, clip, tmp_path):
    clip("a.json", tracks={"mouth": SMILES})
    clip("b.json", tracks={"mouth": [Interval("MouthFrown", 60, 80)], "brow": BROW})
    found = run("merge", "a.json", "b.json", "-o", "out.json")
    assert found.code == 1 and "SoftSmile against MouthFrown on mouth" in found.err
    assert "--prefer first" in found.err and not (tmp_path / "out.json").exists()
    found = run("merge", "a.json", "b.json", "-o", "out.json", "--prefer", "second")
    assert found.code == 0 and "0 cut and 1 left out of a.json" in found.err
    merged = files.read(tmp_path / "out.json")
    assert merged.tracks["brow"] == tuple(BROW)
    assert [i.action for i in merged.tracks["mouth"]] == ["Smile", "MouthFrown"]


def test_lint_has_a_line_for_each_problem_and_its_code_tells_errors(run, clip, tmp_path):
    clip("good.json")
    clip("short.json", tracks={"mouth": [Interval("Smile", 10, 14)]})
    assert run("lint", "good.json").out == "nothing wrong in 1 file\n"
    found = run("lint", "good.json", "short.json", "--min-frames", "5")
    assert found.code == 0 and found.out.startswith("short.json: warning: ")
    assert found.out.endswith("0 errors, 1 warning in 2 files\n")
    (tmp_path / "bad.csv").write_text(
        "clip_id,track,action,start_frame,end_frame\n"
        "c,mouth,Smile,10,30\nc,mouth,SoftSmile,20,40\nc,mouth,Smyle,50,60\n"
    )
    found = run("lint", "bad.csv", "missing.eaf", "--fps", "25", "--frames", "90")
    assert found.code == 1
    *problems, end = found.out.splitlines()
    assert len(problems) == 3 and end == "3 errors, 0 warnings in 2 files"
    assert all(line.startswith(("bad.csv: error: ", "missing.eaf: error: ")) for line in problems)
    assert "Did you mean Smile?" in found.out


def test_lint_tells_programs_the_same(run, clip):
    clip("short.json", tracks={"mouth": [Interval("Smile", 10, 11)]})
    (row,) = json.loads(run("lint", "short.json", "--json").out)
    assert set(row) == {"file", "place", "found", "expected", "remedy", "severity"}
    assert (row["file"], row["severity"]) == ("short.json", "warning")


def test_a_name_in_a_file_cannot_steer_the_terminal(run, clip, tmp_path):
    clip("a.json", clip_id="x\x1b[2Jy")
    clip("b.json", clip_id="x\x1b[2Jy", tracks={"mouth": []})
    (tmp_path / "c.json").write_text('{"clip_id": "\\u001b[2J"}')
    for arguments in (
        ("diff", "a.json", "b.json"),
        ("lint", "c.json"),
        ("convert", "a.json", "a.csv"),
        ("merge", "a.json", "c.json", "-o", "d.json"),
    ):
        found = run(*arguments)
        assert "\x1b" not in found.out + found.err


@pytest.mark.parametrize("command", ["convert", "diff", "merge", "lint", "export"])
def test_the_page_names_every_option(run, command):
    page = (Path(__file__).parents[2] / "docs" / "timelines.md").read_text(encoding="utf-8")
    options = set(re.findall(r"--\w[\w-]*", run(command, "--help").out)) - {"--help", "--out"}
    assert options <= set(re.findall(r"--\w[\w-]*", page))
