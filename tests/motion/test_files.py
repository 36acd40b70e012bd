"""Motion in files: what comes back of each format, and what is refused."""

import json
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import av
import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mimeline import tables
from mimeline.errors import BadFile, MimelineError, NoSuchFile
from mimeline.inspection.options import options
from mimeline.motion import files
from mimeline.tracking.formats.livelink import HEADER
from mimeline.vocabulary import CHANNELS, EXPRESSIONS

GAPS = (".npz", ".parquet")  # which say that a channel is not known
NUMBERS = (".csv", ".glb", *GAPS)
RATES = [Fraction(25), Fraction(30_000, 1001), Fraction(24_000, 1001), Fraction(120)]


def values(motion) -> pd.DataFrame:
    return motion.frames[[*CHANNELS]]


@pytest.mark.parametrize("fps", RATES, ids=str)
@pytest.mark.parametrize("ending", NUMBERS)
def test_a_motion_comes_back(moving, face, tmp_path, ending, fps):
    motion = moving(40, fps)
    written = files.write(motion, tmp_path / f"a{ending}", face)
    assert written.path == tmp_path / f"a{ending}" and written.lost == ()
    found = files.read(written.path, options())
    assert found.fps == fps and len(found) == 40
    np.testing.assert_array_equal(found.frames["valid"], motion.frames["valid"])
    assert dict(found.origins) == dict(motion.origins)
    assert found.timeline == motion.timeline and found.made == motion.made
    seen = motion.frames["valid"].to_numpy(bool)
    was, now = values(motion)[seen], values(found)[seen]
    if ending not in GAPS:
        was = was.fillna(dict.fromkeys(motion.moved, 0.0))  # there is no way to say it
    np.testing.assert_allclose(now, was, atol=2e-6)
    assert found.moved == motion.moved


@settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None, max_examples=15
)
@given(st.data())
def test_any_motion_comes_back_to_the_bit_where_the_format_has_gaps(moving, face, tmp_path, data):
    n = data.draw(st.integers(5, 20))
    motion = moving(n, Fraction(data.draw(st.integers(1, 240)), data.draw(st.integers(1, 1001))))
    numbers = values(motion).to_numpy(np.float32).copy()
    holes = data.draw(st.lists(st.tuples(st.integers(0, n - 1), st.integers(0, len(CHANNELS) - 1))))
    for row, column in holes:
        numbers[row, column] = np.nan
    motion.frames[[*CHANNELS]] = numbers
    for ending in GAPS:
        files.write(motion, tmp_path / f"a{ending}", face)
        found = files.read(tmp_path / f"a{ending}", options())
        assert found.fps == motion.fps
        seen = motion.frames["valid"].to_numpy(bool)
        np.testing.assert_array_equal(values(found)[seen], values(motion)[seen])


def test_a_live_link_take_has_the_header_of_the_app(moving, face, tmp_path, real_data):
    files.write(moving(), tmp_path / "a.csv", face)
    takes = [*(real_data / "arkit_livelink").glob("*.csv")]
    assert takes
    with open(takes[0], encoding="utf-8") as real:
        assert (tmp_path / "a.csv").read_text().splitlines()[0] == real.readline().rstrip("\r\n")


def test_a_live_link_take_is_a_row_for_each_frame_with_a_face(moving, face, tmp_path):
    files.write(moving(), tmp_path / "a.csv", face)
    rows = pd.read_csv(tmp_path / "a.csv")
    assert list(rows.columns) == list(HEADER) and len(rows) == 10
    assert rows["Timecode"].is_unique and (rows["BlendShapeCount"] == 61).all()
    assert (rows["TongueOut"] == 0).all()
    found = files.read(tmp_path / "a.csv", options())
    assert found.frames["tongueOut"].isna().all()  # the file beside tells that it is not known


def test_a_take_is_read_without_the_file_beside_it(moving, face, tmp_path):
    files.write(moving(), tmp_path / "a.csv", face)
    (tmp_path / "a.mimeline.json").unlink()
    found = files.read(tmp_path / "a.csv", options(sets=["fps=30000/1001"]))
    assert found.timeline is None and (found.frames["tongueOut"].dropna() == 0).all()


def test_parquet_opens_in_pandas_as_the_motion_table(moving, face, tmp_path):
    motion = moving()
    files.write(motion, tmp_path / "a.parquet", face)
    rows = pd.read_parquet(tmp_path / "a.parquet")
    assert (rows["clip_id"] == "mine").all() and list(rows["frame"]) == [*range(12)]
    told = json.loads(pq.read_schema(tmp_path / "a.parquet").metadata[b"mimeline.about"])
    assert told["channels"]["jawOpen"] == {
        "measured": True,
        "origin": "column jawOpen",
        "quality": 0.25,
    }


def test_npz_opens_in_numpy_by_names(moving, face, tmp_path):
    motion = moving()
    files.write(motion, tmp_path / "a.npz", face)
    with np.load(tmp_path / "a.npz", allow_pickle=False) as held:
        assert held["motion"].shape == (12, len(motion.moved)) == (12, len(held["channels"]))
        assert tuple(held["fps"]) == (30_000, 1001) and held["valid"].sum() == 10


def test_a_film_has_a_picture_for_each_frame_and_tells_of_its_channels(moving, face, tmp_path):
    motion = moving(8, Fraction(25))
    files.write(motion, tmp_path / "a.mp4", face)
    files.write(replace(motion, timeline=None), tmp_path / "bare.mp4", face)
    shapes = {}
    for name in ("a", "bare"):
        with av.open(str(tmp_path / f"{name}.mp4")) as film:
            pictures = [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]
            assert len(pictures) == 8 and film.streams.video[0].average_rate == 25
            told = json.loads(film.metadata["comment"])
            shapes[name] = pictures[0].shape
    assert told["channels"]["tongueOut"]["measured"] is False
    assert shapes["bare"][0] == shapes["bare"][1] < shapes["a"][0]
    with av.open(str(tmp_path / "a.mp4")) as film:
        pictures = [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]
    pale, seen = pictures[3][:300].mean(), pictures[5][:300].mean()
    assert pale > seen + 5  # frame 3 shows no face
    moves = [np.abs(a[520:].astype(int) - b[520:]).max() for a, b in pairwise(pictures)]
    assert min(moves) > 50  # the line goes on


def test_obj_files_are_a_folder_numbered_by_frame(moving, face, tmp_path):
    motion = moving()
    written = files.write(motion, tmp_path / "a.obj", face)
    assert written.path == tmp_path / "a"
    names = sorted(path.name for path in written.path.glob("*.obj"))
    assert names == [f"a_{frame:05d}.obj" for frame in range(12) if frame not in (3, 4)]
    lines = (written.path / names[0]).read_text().splitlines()
    assert sum(line.startswith("v ") for line in lines) == len(face.neutral)
    assert sum(line.startswith("f ") for line in lines) == len(face.triangles)
    assert json.loads((written.path / "a.mimeline.json").read_text())["frames"] == 12


@pytest.mark.parametrize("ending", [".csv", ".glb", ".obj"])
def test_a_motion_without_a_face_is_refused_where_frames_go(moving, face, tmp_path, ending):
    motion = moving()
    motion.frames["valid"] = False
    if ending == ".obj":
        files.write(motion, tmp_path / "a.obj", face)
        assert [path.suffix for path in (tmp_path / "a").iterdir()] == [".json"]
        return
    with pytest.raises(BadFile, match="without a valid frame"):
        files.write(motion, tmp_path / f"a{ending}", face)
    assert [*tmp_path.iterdir()] == []


@pytest.mark.parametrize("name", ["a", "a.avi", "a.blend", "a.gltf", ".csv"])
def test_an_ending_of_no_format_is_refused(moving, face, tmp_path, name):
    with pytest.raises(BadFile, match="Name the file by what it is to be"):
        files.write(moving(), tmp_path / name, face)


def test_a_place_that_cannot_be_written_to_is_told(moving, face, tmp_path):
    (tmp_path / "file").write_text("mine")
    for ending in (*NUMBERS, ".mp4", ".obj"):
        with pytest.raises(BadFile, match="a place to write to"):
            files.write(moving(), tmp_path / "file" / f"a{ending}", face)


def test_what_is_no_motion_is_refused(tmp_path):
    with pytest.raises(NoSuchFile):
        files.read(tmp_path / "nowhere.glb", options())
    for name in ("a.txt", "a.mp4", "a.npz", "a.parquet", "a.glb", "a.csv", "a"):
        (tmp_path / name).write_text("words")
        with pytest.raises(MimelineError) as caught:
            files.read(tmp_path / name, options())
        assert len(str(caught.value).splitlines()) == 1


SPOILT = {
    "fps of 0": {"fps": np.array([0, 1])},
    "fps of one number": {"fps": np.array([25])},
    "channels twice": {"channels": np.array(["jawOpen", "jawOpen"])},
    "unknown channels": {"channels": np.array(["jawOpen", "hair"])},
    "fewer frames": {"valid": np.ones(3, bool)},
    "no frame": {"motion": np.zeros((0, 2), "f4"), "valid": np.zeros(0, bool)},
    "text": {"motion": np.full((5, 2), "x")},
    "beyond numbers": {"motion": np.full((5, 2), np.inf, "f4")},
    "about that is no JSON": {"about": np.array("{")},
    "about that is a list": {"about": np.array("[]")},
    "about of bytes": {"about": np.array(b"\xff")},
}


@pytest.mark.parametrize("how", SPOILT)
def test_arrays_that_do_not_fit_are_one_typed_error(tmp_path, how):
    sound = {
        "channels": np.array(["jawOpen", "browInnerUp"]),
        "motion": np.zeros((5, 2), "f4"),
        "valid": np.ones(5, bool),
        "fps": np.array([25, 1]),
        "about": np.array("{}"),
    }
    np.savez(tmp_path / "a.npz", **sound)
    assert len(files.read(tmp_path / "a.npz", options())) == 5
    np.savez(tmp_path / "a.npz", **sound | SPOILT[how])
    with pytest.raises(BadFile) as caught:
        files.read(tmp_path / "a.npz", options())
    assert str(caught.value).startswith(str(tmp_path / "a.npz"))


def test_a_run_s_table_of_several_clips_is_refused_with_how_to_take_one_out(moving, tmp_path):
    rows = moving().frames.assign(clip_id="a")
    both = pd.concat([rows, rows.assign(clip_id="b")])
    for content, found in (
        (both, "2 clips"),
        (rows, "no frames per second"),
        (rows[:0], "0 clips"),
    ):
        tables.write(tables.MOTION, content, tmp_path / "run.parquet")
        with pytest.raises(BadFile, match=f"{found}.*motion export"):
            files.read(tmp_path / "run.parquet", options())


def test_a_table_without_a_rate_is_refused(moving, face, tmp_path):
    files.write(moving(), tmp_path / "a.parquet", face)
    table = pq.read_table(tmp_path / "a.parquet")
    told = json.loads(table.schema.metadata[b"mimeline.about"])
    for fps in (None, "0", "often", 25, {}):
        metadata = {b"mimeline.about": json.dumps(told | {"fps": fps}).encode()}
        pq.write_table(table.replace_schema_metadata(metadata), tmp_path / "a.parquet")
        with pytest.raises(BadFile, match="frames per second"):
            files.read(tmp_path / "a.parquet", options())


@settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None, max_examples=60
)
@given(st.data())
def test_a_spoilt_file_is_read_or_refused(moving, face, tmp_path, data):
    ending = data.draw(st.sampled_from(NUMBERS))
    path = tmp_path / f"a{ending}"
    files.write(moving(), path, face)
    beside = tmp_path / "a.mimeline.json"
    spoilt = beside if ending == ".csv" and data.draw(st.booleans()) else path
    content = bytearray(spoilt.read_bytes())
    for _ in range(data.draw(st.integers(1, 3))):
        at = data.draw(st.integers(0, max(0, min(len(content) - 1, 4000))))
        if data.draw(st.booleans()):
            content[at : at + 1] = bytes([data.draw(st.integers(0, 255))])
        else:
            del content[at : at + data.draw(st.integers(1, 200))]
    spoilt.write_bytes(content)
    try:
        found = files.read(path, options())
    except MimelineError:
        return
    assert found.fps > 0 and len(found) > 0
    assert list(found.frames["frame"]) == [*range(len(found))]
    assert np.isfinite(found.frames[[*EXPRESSIONS]].to_numpy(float, na_value=0)).all()
