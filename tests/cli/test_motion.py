from fractions import Fraction

import cv2
import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.annotation.annotate import intervals_of
from mimeline.inspection.options import options
from mimeline.ledger import Ledger
from mimeline.motion import files
from mimeline.timeline import files as timeline_files
from mimeline.timeline.timeline import Interval, Timeline
from mimeline.tracking.formats import livelink
from mimeline.tracking.origins import origins_of
from mimeline.tracking.take import Origin, Take, assemble
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


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """Results up to annotate: clips -a and b of 40 frames, and c, of which there is no motion."""
    results = tmp_path_factory.mktemp("run") / "results"
    rng = np.random.default_rng(1)
    blank = dict.fromkeys(tables.CLIPS.schema.names) | {"start_s": 0.0, "end_s": 1.6, "shard": 0}
    blank |= {"fps_num": 25, "fps_den": 1, "n_frames": FRAMES}
    blank |= {name: [] for name in ("actions", "emotions", "attributes", "texts")}
    clips = pd.DataFrame([blank | {"clip_id": i, "source_id": i} for i in ("-aa", "b", "c")])
    for stage in ("catalogue", "ingest"):
        passed = clips[:2] if stage == "ingest" else clips
        ledger = Ledger(stage, clips["clip_id"])
        if stage == "ingest":
            ledger.fail("c", "unreadable")
        tables.write(tables.CLIPS, passed, results / stage / "00" / "clips.parquet")
        folder = results / stage if stage == "catalogue" else results / stage / "00"
        ledger.close(folder / "ledger.parquet", passed["clip_id"])
    frame, takes = np.arange(FRAMES), []
    for _ in range(2):
        values = pd.DataFrame({name: rng.uniform(0, 0.5, FRAMES) for name in CHANNELS})
        takes.append(assemble(frame, np.ones(FRAMES, bool), values, np.nan, "take"))
    rows = pd.concat([own.assign(clip_id=i) for own, i in zip(takes, ("-aa", "b"), strict=True)])
    tables.write(tables.MOTION, rows, results / "ingest" / "00" / "motion.parquet")
    origins = {name: Origin(f"column {name}", quality=0.4) for name in CHANNELS}
    told = [Take(takes[0], Fraction(25), origins=origins)]
    tables.write(tables.ORIGINS, origins_of(told), results / "ingest" / "00" / "origins.parquet")
    marks = dict.fromkeys(tables.FRAMES.schema.names[2:], False) | {"Smile": frame >= 10}
    frames = pd.DataFrame({"clip_id": "b", "frame": frame}).assign(**marks)
    tables.write(tables.FRAMES, frames, results / "annotate" / "00" / "frames.parquet")
    found = intervals_of(frames, {})
    tables.write(tables.INTERVALS, found, results / "annotate" / "00" / "intervals.parquet")
    return results


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


def test_frames_without_a_face_are_counted(convert, take, tmp_path):
    err = convert(take, "b.glb")[2]
    assert "38 frames at 30 per second, without the 2 that show no face" in err
    assert "40 frames at 30 per second\n" in convert(take, "b.npz")[2]
    err = convert(take, "b.mp4")[2]
    assert "40 frames at 30 per second, pale in the 2 that show no face" in err
    assert cv2.VideoCapture(str(tmp_path / "b.mp4")).get(cv2.CAP_PROP_FRAME_COUNT) == 40


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
    assert convert(take, "other.csv", "made", "--to", "npz,glb")[0] == 0
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


def test_a_run_s_motion_comes_with_its_timelines_and_origins(mimeline, finished, tmp_path):
    run = ["motion", "export", "--results", finished]
    code, _, err = mimeline(*run, "-o", tmp_path / "made", "--to", "npz,csv")
    assert code == 0 and err.count("wrote ") == 4
    found = {name: motion(tmp_path / "made" / f"{name}.npz") for name in ("-aa", "b")}
    rows = tables.read(tables.MOTION, finished / "ingest" / "00" / "motion.parquet")
    for name, own in found.items():
        assert own.fps == 25 and own.origins["jawOpen"].quality == 0.4
        told = rows[rows["clip_id"] == name]
        np.testing.assert_array_equal(own.frames[[*CHANNELS]], told[[*CHANNELS]])
    assert found["-aa"].timeline is None
    assert [(i.action, i.start, i.end) for i in found["b"].timeline] == [("Smile", 10, FRAMES)]


def test_a_clip_of_a_run_goes_into_a_file_and_what_is_missed_is_told(mimeline, finished, tmp_path):
    run = ["motion", "export", "--results", finished]
    assert mimeline(*run, "-aa", "-o", tmp_path / "a.glb")[0] == 0
    assert len(motion(tmp_path / "a.glb")) == FRAMES
    code, _, err = mimeline(*run, "b", "c", "nobody", "-o", tmp_path / "made", "--to", "npz")
    assert code == 1 and (tmp_path / "made" / "b.npz").is_file()
    assert "c has no motion: mimeline why" in err and "clip 'nobody'" in err
    code, _, err = mimeline(*run, "c", "-o", tmp_path / "c.npz")
    assert code == 1 and "no motion of a clip that you name" in err
    code, _, err = mimeline("motion", "export", "--results", tmp_path, "-o", tmp_path / "x.npz")
    assert code == 1 and "no ledger" in err


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["nowhere.csv", "b.npz"], "nowhere.csv: found no such file"),
        (["bad.csv", "b.npz"], "bad.csv"),
        (["bad.glb", "b.npz"], "bad.glb: found a file that begins with"),
        (["bad.csv", "b.avi"], "ends in .avi"),
        (["bad.csv", "b"], "Say it, as --to csv,glb."),
    ],
)
def test_what_cannot_be_converted_is_one_line_and_leaves_nothing(convert, tmp_path, words, told):
    for name in ("bad.csv", "bad.glb"):
        (tmp_path / name).write_text("words\n")
    code, out, err = convert(*words)
    assert (code, out) == (1, "") and told in err and len(err.splitlines()) == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bad.csv", "bad.glb"]
