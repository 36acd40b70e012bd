from fractions import Fraction

import numpy as np
import pandas as pd
import pytest

from mimeline.inspection.options import options
from mimeline.motion import files
from mimeline.timeline import files as timeline_files
from mimeline.timeline.timeline import Interval, Timeline
from mimeline.tracking.formats import livelink
from mimeline.tracking.take import assemble
from mimeline.vocabulary import CHANNELS

FRAMES = 40


@pytest.fixture(scope="module")
def take(tmp_path_factory):
    """A Live Link Face take of 40 frames at 30 per second, two of them without a face."""
    rng = np.random.default_rng(0)
    values = {name: rng.uniform(0, 0.5, FRAMES) for name in CHANNELS}
    valid = np.arange(FRAMES) // 2 != 10
    frames = assemble(np.arange(FRAMES), valid, pd.DataFrame(values), np.nan, "take")
    path = tmp_path_factory.mktemp("motion") / "take.csv"
    livelink.write(path, frames, Fraction(30))
    return path


@pytest.fixture
def convert(mimeline, monkeypatch, tmp_path):
    """Runs `mimeline motion convert` in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    return lambda *words: mimeline("motion", "convert", *words)


def motion(path):
    return files.read(path, options())


@pytest.mark.parametrize("target", ["b.csv", "b.glb", "b.npz", "b.parquet"])
def test_a_take_goes_into_each_format_and_back(convert, take, tmp_path, target):
    code, out, err = convert(take, target)
    assert (code, out) == (0, "") and f"wrote {target}" in err
    assert convert(target, "back.csv")[0] == 0
    was, now = (motion(path) for path in (take, tmp_path / "back.csv"))
    assert now.fps == was.fps == 30
    both = was.frames["valid"].to_numpy(bool)
    np.testing.assert_array_equal(now.frames["valid"], both)
    columns = [*CHANNELS]
    np.testing.assert_allclose(
        now.frames[columns][both], was.frames[columns][both], atol=2e-6, equal_nan=True
    )


def test_frames_without_a_face_are_counted(convert, take):
    err = convert(take, "b.glb")[2]
    assert "38 frames at 30 per second, without the 2 that show no face" in err


def test_another_rate_keeps_the_length(convert, take, tmp_path):
    assert convert(take, "b.npz", "--fps", "25")[0] == 0
    found = motion(tmp_path / "b.npz")
    assert found.fps == 25 and len(found) == 33


def test_a_timeline_goes_along(convert, take, tmp_path):
    smile = {"mouth": [Interval("Smile", 10, 30)]}
    timeline_files.write(Timeline("t", Fraction(30), FRAMES, smile), tmp_path / "t.json")
    timeline_files.write(Timeline("t", Fraction(30), 90, smile), tmp_path / "long.json")
    assert convert(take, "b.npz", "--timeline", "t.json")[0] == 0
    assert [own.action for own in motion(tmp_path / "b.npz").timeline] == ["Smile"]
    code, _, err = convert(take, "c.npz", "--timeline", "long.json")
    assert code == 1 and "long.json: found 1 timeline (3 s), expected one of 1.333 s" in err


def test_several_go_into_a_folder(convert, take, tmp_path):
    (tmp_path / "other.csv").write_bytes(take.read_bytes())
    assert convert(take, "other.csv", "made", "--to", "npz", "glb")[0] == 0
    names = ["other.glb", "other.npz", "take.glb", "take.npz"]
    assert sorted(path.name for path in (tmp_path / "made").iterdir()) == names
    code, _, err = convert(take, "other.csv", "made", "--to", "npz")
    assert code == 1 and "take.npz and 1 more already" in err


def test_the_file_that_is_read_is_not_written(convert, take):
    before = take.read_bytes()
    code, _, err = convert(take, take, "--overwrite")
    assert code == 1 and "the file that is read" in err
    assert take.read_bytes() == before


def test_how_a_take_is_read_can_be_said(convert, take, tmp_path):
    assert convert(take, "b.npz", "--set", "angle_unit=degrees")[0] == 0
    head = "head_yaw_left"
    now, was = (motion(path).frames[head].to_numpy() for path in (tmp_path / "b.npz", take))
    np.testing.assert_allclose(now, np.radians(was), atol=1e-5)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["nowhere.csv", "b.npz"], "nowhere.csv: found no such file"),
        (["bad.csv", "b.npz"], "bad.csv"),
        (["bad.glb", "b.npz"], "bad.glb: found a file that begins with"),
        (["bad.csv", "b.avi"], "ends in .avi"),
        (["bad.csv", "b"], "Say it, as --to csv glb."),
    ],
)
def test_what_cannot_be_converted_is_one_line_and_leaves_nothing(convert, tmp_path, words, told):
    for name in ("bad.csv", "bad.glb"):
        (tmp_path / name).write_text("words\n")
    code, out, err = convert(*words)
    assert (code, out) == (1, "") and told in err and len(err.splitlines()) == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bad.csv", "bad.glb"]
