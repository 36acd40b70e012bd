import json

import av
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mimeline.clips.catalogues.faces import read_faces
from mimeline.errors import MimelineError, NoSuchFile

KEYS = st.sampled_from(["0", "1", "p0", "people", "bbox", "current_speaker"])
LEFT, RIGHT = [10, 10, 30, 40], [60, 12, 80, 44, 0.99]


@pytest.fixture(scope="module")
def data(tmp_path_factory, put):
    """A video without annotations."""
    return put(tmp_path_factory.mktemp("realtalk"), "videos/-abcdefghij.mp4")


@pytest.fixture
def annotated(data, tmp_path):
    """Annotates the video: frame → {person: box}, {frame: speaker}."""

    def annotated(people: dict, speakers: dict | None = None):
        frames = {
            str(n): {"people": {p: {"bbox": box} for p, box in people.get(n, {}).items()}}
            | {"current_speaker": (speakers or {}).get(n)}
            for n in range(75)
        }
        return written(json.dumps(frames))

    def written(text: str):
        folder = data / tmp_path.name
        folder.mkdir()
        (folder / "-abcdefghij.json").write_text(text)
        return folder.name

    annotated.written = written
    return annotated


def test_without_annotations_each_person_is_half_of_the_picture(data, catalogued):
    found = catalogued(data, "realtalk", annotations=None)
    clips = found.clips
    assert clips.index.tolist() == ["-abcdefghij_p0", "-abcdefghij_p1"]
    assert found.ledger["rule"].tolist() == ["half_picture"] * 2
    assert clips["subject_id"].tolist() == clips.index.tolist()
    assert set(clips["source_id"]) == {"-abcdefghij"}
    assert set(clips["video"]) == {"videos/-abcdefghij.mp4"}
    assert clips[["bbox_left", "bbox_right"]].to_numpy().tolist() == [[0, 48], [48, 96]]
    assert clips[["bbox_top", "bbox_bottom"]].to_numpy().tolist() == [[0, 64], [0, 64]]
    assert clips[["start_s", "end_s"]].to_numpy().tolist() == [[0, 3], [0, 3]]


def test_each_person_is_cut_into_pieces(data, catalogued):
    clips = catalogued(data, "realtalk", annotations=None, cut_s=2.0).clips
    assert clips.index.tolist() == [
        f"-abcdefghij_{person}_{piece}" for person in ("p0", "p1") for piece in ("000", "001")
    ]
    assert clips.loc["-abcdefghij_p1_001", ["start_s", "end_s"]].tolist() == [2.0, 3.0]


def test_a_stretch_is_where_a_face_is_and_its_box_holds_it_with_a_margin(
    data, annotated, catalogued
):
    people = {n: {"p0": [10 + n / 10, 10, 30 + n / 10, 40], "p1": RIGHT} for n in range(75)}
    for n in range(30, 45):
        del people[n]["p1"]
    for n in (5, 6, 7):  # a detector's slip
        del people[n]["p0"]
    clips = catalogued(data, "realtalk", annotations=annotated(people), margin=0.25).clips
    assert clips.index.tolist() == [
        "-abcdefghij_p0_000000",
        "-abcdefghij_p1_000000",
        "-abcdefghij_p1_000045",
    ]
    assert clips[["start_s", "end_s"]].to_numpy().tolist() == [[0, 3], [0, 1.2], [1.8, 3]]
    assert set(clips["subject_id"]) == {"-abcdefghij_p0", "-abcdefghij_p1"}
    box = clips.iloc[0][["bbox_left", "bbox_right", "bbox_top", "bbox_bottom"]]
    assert box.tolist() == [5, 42, 2, 48]  # a quarter of 20 and of 30 pixels, rounded to even
    assert clips.iloc[0][["width", "height"]].tolist() == [37, 46]


def test_a_cut_of_the_camera_ends_a_stretch_and_a_short_one_is_none(data, annotated, catalogued):
    people = {n: {"p0": LEFT if n < 40 else RIGHT} for n in range(75)} | {
        n: {"p0": [40, 10, 60, 40]} for n in range(30, 40)
    }
    clips = catalogued(data, "realtalk", annotations=annotated(people)).clips
    assert clips.index.tolist() == ["-abcdefghij_p0_000000", "-abcdefghij_p0_000040"]


def test_a_frame_more_than_the_video_has_is_left_out(data, annotated, catalogued):
    frames = {n: {"people": {"p0": {"bbox": LEFT}}, "current_speaker": "p0"} for n in range(77)}
    clips = catalogued(data, "realtalk", annotations=annotated.written(json.dumps(frames))).clips
    assert clips["end_s"].tolist() == [3.0]
    assert clips["actions"].iloc[0][0]["end_s"] == 3.0


def test_who_speaks_is_an_action_of_that_person(data, annotated, catalogued):
    people = {n: {"p0": LEFT, "p1": RIGHT} for n in range(25, 75)}
    speakers = dict.fromkeys(range(50), "p0") | dict.fromkeys(range(50, 60), "p1")
    clips = catalogued(data, "realtalk", annotations=annotated(people, speakers)).clips
    (talk,) = clips.loc["-abcdefghij_p0_000025", "actions"]
    assert (talk["name"], talk["start_s"], talk["end_s"]) == ("talk", 0.0, 1.0)
    (talk,) = clips.loc["-abcdefghij_p1_000025", "actions"]
    assert (talk["start_s"], talk["end_s"]) == (1.0, 1.4)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("<html>404</html>", "an HTML page"),
        ("version https://git-lfs.github.com/spec/v1", "a Git LFS pointer"),
        ("[1]", "found list"),
        ("{}", "no frame with a face"),
        ('{"0": {"people": {}}}', "no frame with a face"),
        ('{"-1": {}}', "'-1' where a frame's number belongs"),
        ('{"0": {"people": {"p0": {"bbox": [1, 2]}}}}', "frame 0"),
        ('{"0": {"people": {"p0": {"bbox": [9, 2, 1, 5]}}}}', "1 of 1 boxes"),
        ('{"0": {"people": {"p0": {"bbox": [NaN, 2, 1, 5]}}}}', "1 of 1 boxes"),
        ('{"0": {"people": ["p0"]}}', "frame 0"),
        ('{"0": {"people": {"p0": "left"}}}', "frame 0"),
        ('{"0": 7}', "frame 0"),
        ('{"80": {"people": {"p0": {"bbox": [1, 2, 3, 4]}}}}', "up to frame 80"),
        ('{"0": {"people": {"p0": {"bbox": [1, 2, 1279, 4]}}}}', "outside of the picture"),
    ],
)
def test_annotations_that_are_none_fail_both_people_of_the_video(
    data, annotated, catalogued, text, found
):
    ledger = catalogued(data, "realtalk", annotations=annotated.written(text)).ledger
    assert ledger["status"].tolist() == ["failed", "failed"]
    assert found in ledger["detail"].iloc[0]


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=3),
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(KEYS, inner, max_size=3),
    max_leaves=12,
)
EDGES = st.floats() | st.integers(0, 9) | st.sampled_from([10**400, -1, "9"])
FACE = JSON | st.fixed_dictionaries({"bbox": JSON | st.lists(EDGES, min_size=3, max_size=5)})
PEOPLE = JSON | st.dictionaries(st.sampled_from(["p0", "p1"]), FACE)
FRAME = JSON | st.fixed_dictionaries({"people": PEOPLE, "current_speaker": JSON})


@settings(
    max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(st.dictionaries(st.sampled_from(["0", "1", "60", "x"]), FRAME, max_size=3))
def test_hostile_annotations_raise_nothing_else(tmp_path, content):
    (tmp_path / "a.json").write_text(json.dumps(content))
    try:
        faces = read_faces(tmp_path / "a.json", ("p0", "p1"))
    except MimelineError:
        return
    assert all(len(list(faces.stretches(person))) <= 3 for person in ("p0", "p1"))


def test_an_avi_is_read_and_another_rate_than_the_annotations_is_refused(tmp_path, catalogued):
    for name, rate in (("a", 25), ("b", 30)):
        (tmp_path / "data" / "videos").mkdir(parents=True, exist_ok=True)
        with av.open(str(tmp_path / "data" / "videos" / f"{name}.avi"), "w") as film:
            stream = film.add_stream("mpeg4", rate=rate)
            stream.height, stream.width, stream.pix_fmt = 64, 96, "yuv420p"
            for _ in range(30):
                picture = np.zeros((64, 96, 3), np.uint8)
                film.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
            film.mux(stream.encode(None))
        (tmp_path / "data" / "metadata").mkdir(exist_ok=True)
        frames = {n: {"people": {"p0": {"bbox": LEFT}}, "current_speaker": None} for n in range(30)}
        (tmp_path / "data" / "metadata" / f"{name}.json").write_text(json.dumps(frames))
    found = catalogued(tmp_path / "data", "realtalk")
    assert found.clips[["start_s", "end_s"]].to_numpy().tolist() == [[0.0, 1.2]]
    assert "30 frames per second, expected 25" in found.ledger.loc["b_p0", "detail"]


def test_a_folder_that_is_not_there_stops_the_run(tmp_path, catalogued):
    with pytest.raises(NoSuchFile, match=r"catalogue\.realtalk\.folder"):
        catalogued(tmp_path, "realtalk")
