import tracemalloc
import zipfile
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mimeline.errors import BadFile, NoSuchFile
from mimeline.face.rotations import turned
from mimeline.tables import COEFFICIENTS
from mimeline.tracking.formats import flame
from mimeline.tracking.take import MOST_FRAMES, Take
from mimeline.vocabulary import HEAD

GOLDEN = Path(__file__).parents[1] / "golden" / "flame"
QUICK = settings(
    max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


def taken(folder: Path, bad_values: str = "fail", rate: str = "25", **arrays) -> Take:
    np.savez(folder / "take.npz", **arrays)
    return flame.read(folder / "take.npz", fps=rate, face=None, bad_values=bad_values)


def about_y(*angles: float) -> np.ndarray:
    return np.array([[0, angle, 0] for angle in angles])


def test_every_name_of_a_coefficient_means_the_same(tmp_path):
    expression, turn, jaw = np.full((2, 50), 0.5), about_y(0, 0.2), np.array([[0.1, 0, 0]] * 2)
    layouts = [
        {"expression": expression, "global_orient": turn, "jaw_pose": jaw},
        {"exp": expression, "pose": np.hstack([turn, jaw])},
        {"expcode": expression, "rotation": turn, "jaw": jaw},
        {"expr": expression, "pose": turn, "jaw_pose": jaw},
    ]
    tables = [taken(tmp_path, **layout).coefficients["flame"] for layout in layouts]
    assert list(tables[0]) == COEFFICIENTS["flame"].schema.names[2:]
    for table in tables[1:]:
        pd.testing.assert_frame_equal(table, tables[0])


def test_a_pose_of_fifteen_is_root_neck_jaw_and_eyes(tmp_path):
    pose = np.arange(30).reshape(2, 15) / 100
    table = taken(tmp_path, pose=pose).coefficients["flame"]
    joints = [c for c in table if not c.startswith(("exp", "eyelid"))]
    np.testing.assert_allclose(table[joints], pose, atol=1e-6)


def test_mmhead_is_expression_neck_and_jaw(tmp_path):
    array = np.zeros((2, 56))
    array[1, 51], array[1, 53] = 0.2, 0.1  # the neck about y, the jaw about x
    take = taken(tmp_path, mmhead=array)
    np.testing.assert_allclose(take.motion["head_yaw_left"], [0, 0.2], atol=1e-6)
    assert take.motion["jawOpen"].iloc[1] > 0.1
    assert take.coefficients["flame"].filter(like="head").isna().all(axis=None)


def test_the_head_turns_with_root_and_neck_together(tmp_path):
    take = taken(tmp_path, global_orient=about_y(0, 0.2), neck=about_y(0, 0.1))
    np.testing.assert_allclose(take.motion["head_yaw_left"], [0, 0.3], atol=1e-6)


def test_the_neck_turns_within_the_root(tmp_path):
    """The root tilts a head by 1.2 to its left, the neck lifts it by 0.5 about its own ears' axis:
    the nose goes towards the crown, which points to the subject's left and up. The other way round
    it would go straight up.
    """
    tilt, lift = np.array([[0, 0, -1.2]]), np.array([[-0.5, 0, 0]])
    crown, forward = np.array([np.sin(1.2), np.cos(1.2), 0]), np.array([0, 0, 1])
    motion = taken(tmp_path, global_orient=tilt, neck=lift).motion
    found = turned(*(motion[name].to_numpy() for name in HEAD))[0]
    nose, top = found[:, 2], found[:, 1]
    np.testing.assert_allclose(nose, np.sin(0.5) * crown + np.cos(0.5) * forward, atol=1e-5)
    np.testing.assert_allclose(top, np.cos(0.5) * crown - np.sin(0.5) * forward, atol=1e-5)


def test_arrays_that_are_left_alone_are_named_where_something_is_not_measured(tmp_path):
    exp = np.zeros((2, 50))
    take = taken(tmp_path, exp=exp, jaw_rotation=exp[:, :3], head_pose=exp[:, :3])
    for name, why in (("jawOpen", "no jaw rotation is given"), ("head_yaw_left", "no rotation")):
        assert take.origins[name].text.startswith(why)
        assert take.origins[name].text.endswith("; left alone: head_pose, jaw_rotation")
    assert "left alone" not in taken(tmp_path, exp=exp).origins["jawOpen"].text


@pytest.mark.parametrize("name", ["fps", "mocap_frame_rate"])
def test_a_files_own_rate_goes_by_two_names(tmp_path, name):
    with pytest.raises(BadFile, match="30"):
        taken(tmp_path, pose=np.zeros((2, 3)), **{name: 30.0})
    assert taken(tmp_path, pose=np.zeros((2, 3)), **{name: 25.0}).fps == 25


def test_an_array_that_is_left_alone_is_not_unpacked(tmp_path):
    arrays = {"exp": np.zeros((2, 50)), "verts": np.zeros((2000, 1000))}
    np.savez_compressed(tmp_path / "take.npz", **arrays)
    tracemalloc.start()
    flame.read(tmp_path / "take.npz", fps="25", face=None, bad_values="fail")
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < arrays["verts"].nbytes / 2


def test_every_name_of_an_array_is_on_the_page_that_the_remedy_names():
    page = (Path(__file__).parents[3] / "docs" / "mapping.md").read_text()
    assert "docs/mapping.md" in flame.REMEDY
    assert [name for name in sorted(flame.KNOWN) if f"`{name}`" not in page] == []


def test_what_is_not_told_is_not_measured(tmp_path):
    take = taken(tmp_path, exp=np.zeros((2, 50)), betas=np.ones(300), verts=np.ones((2, 9, 3)))
    assert take.motion[list(HEAD)].isna().all(axis=None)
    assert not take.origins["head_yaw_left"].measured
    assert not take.origins["gaze_left"].measured
    assert take.coefficients["flame"].filter(like="jaw").isna().all(axis=None)


def test_a_take_of_a_camera_with_y_down_is_turned_back(tmp_path):
    """The rotation by pi about x, then by 0.3 about the camera's y, which points down."""
    turn = np.array([[1, 0, 0], [0, -1, 0], [0, 0, -1]])
    c, s = np.cos(0.3), np.sin(0.3)
    R = np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]) @ turn  # the nose goes to the picture's right
    assert (R @ [0, 0, 1])[0] > 0
    values, vectors = np.linalg.eig(R)
    axis = np.real(vectors[:, np.argmin(abs(values - 1))])
    take = taken(tmp_path, global_orient=np.pi * np.array([axis, axis]))
    np.testing.assert_allclose(take.motion["head_yaw_left"], 0.3, atol=1e-5)
    np.testing.assert_allclose(take.motion[["head_pitch_up", "head_tilt_left"]], 0, atol=1e-5)
    assert "turned by pi" in take.origins["head_yaw_left"].text


@pytest.mark.parametrize("turn", [(0, np.pi, 0), (0, 0, np.pi)])
def test_a_head_that_faces_away_or_hangs_down_is_refused(tmp_path, turn):
    with pytest.raises(BadFile, match="away from the camera|upside down"):
        taken(tmp_path, global_orient=np.array([turn] * 3))


def test_frames_that_are_left_out_are_gaps(tmp_path):
    take = taken(tmp_path, global_orient=about_y(0, 0.1, 0.2), frame=np.array([0, 1, 4]))
    assert take.motion["valid"].tolist() == [True, True, False, False, True]
    assert take.coefficients["flame"]["head_y"].notna().tolist() == [True, True, False, False, True]


@pytest.mark.parametrize(
    "frame",
    [[0, 1, 1], [2, 1, 0], [0, 0.5, 1], [-1, 0, 1], [0, 1], [0, 1, MOST_FRAMES], [[0, 1, 2]]],
)
def test_frame_numbers_that_do_not_rise_are_refused(tmp_path, frame):
    with pytest.raises(BadFile, match="array frame"):
        taken(tmp_path, pose=about_y(0, 0, 0), frame=np.array(frame))


@pytest.mark.parametrize(
    ("arrays", "found"),
    [
        ({"exp": np.zeros((2, 50)), "expcode": np.zeros((2, 50))}, "exp000 in both"),
        ({"pose": np.zeros((2, 6)), "jaw_pose": np.zeros((2, 3))}, "jaw_x in both"),
        ({"eyes_pose": np.zeros((2, 6)), "leye_pose": np.zeros((2, 3))}, "left_eye_x in both"),
        ({"frame": np.arange(2), "frames": np.arange(2), "pose": np.zeros((2, 3))}, "both"),
        ({"pose": np.zeros((2, 7))}, r"\(frames, 3 or 6 or 15\)"),
        ({"exp": np.zeros((2, 101))}, r"\(frames, up to 100\)"),
        ({"exp": np.zeros(50)}, r"shape \(50,\)"),
        ({"exp": np.zeros((1, 2, 50))}, r"shape \(1, 2, 50\)"),
        ({"exp": np.zeros((0, 50))}, "0 rows"),
        ({"exp": np.zeros((2, 50)), "jaw": np.zeros((3, 3))}, "3 rows"),
        ({"exp": np.full((2, 50), "a")}, "type <U1"),
        ({"exp": np.zeros((2, 50), complex)}, "type complex128"),
        ({"exp": np.zeros((2, 50)), "fps": np.array("25")}, "array fps"),
        ({"exp": np.zeros((2, 50)), "valid": np.ones(3)}, "array valid"),
        ({"motion": np.zeros((2, 56))}, "arrays motion"),
        ({}, "arrays of no name"),
        ({"jaw": np.array([[8.0, 0, 0], [12, 0, 0]])}, "rotation of jaw"),  # degrees
        ({"pose": np.array([[0, 20.0, 0], [0, 5, 0]])}, "rotation of head"),
        ({"exp": np.full((2, 50), 1e6)}, "exp000"),
        ({"eyelids": np.array([[0.0, 1], [0, 5]])}, "eyelid_right, row 1"),
        ({"eyelids": np.array([[-3.0, 1], [0, 1]])}, "eyelid_left, row 0"),
    ],
)
def test_what_is_no_sequence_of_coefficients_is_refused(tmp_path, arrays, found):
    with pytest.raises(BadFile, match=found):
        taken(tmp_path, **arrays)


def test_the_files_own_rate_must_be_the_configured(tmp_path):
    pose = np.zeros((2, 3))
    assert taken(tmp_path, rate="30000/1001", pose=pose).fps == Fraction(30000, 1001)
    np.savez(tmp_path / "a.npz", pose=pose, fps=29.97)
    flame.read(tmp_path / "a.npz", fps="30000/1001", face=None, bad_values="fail")
    with pytest.raises(BadFile, match=r"30 frames per second.*ingest.flame.fps"):
        flame.read(tmp_path / "a.npz", fps="30", face=None, bad_values="fail")


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e300])
def test_a_number_that_is_none_fails_or_masks_its_frame(tmp_path, value):
    pose = np.zeros((3, 3))
    pose[1, 2] = value
    with pytest.raises(BadFile, match="frame 1"):
        taken(tmp_path, pose=pose)
    assert taken(tmp_path, "mask", pose=pose).motion["valid"].tolist() == [True, False, True]


def test_arrays_of_objects_are_never_unpickled(tmp_path):
    with pytest.raises(BadFile):
        taken(tmp_path, exp=np.array([[open], [print]], dtype=object))


def test_other_files_are_refused_and_held_for_none(tmp_path):
    text, shell = tmp_path / "text.npz", tmp_path / "shell.npz"
    text.write_text("expression")
    with zipfile.ZipFile(shell, "w") as archive:
        archive.writestr("expression.npy", b"\x93NUMPY\x01\x00")
    for path in (text, shell):
        with pytest.raises(BadFile):
            flame.read(path, fps="25", face=None, bad_values="fail")
    with pytest.raises(NoSuchFile):
        flame.read(tmp_path / "none.npz", fps="25", face=None, bad_values="fail")
    assert not flame.holds(text)
    assert not flame.holds(tmp_path / "none.npz")
    assert not flame.holds(tmp_path)
    np.savez(tmp_path / "other.npz", vertices=np.zeros(3))
    assert not flame.holds(tmp_path / "other.npz")


@st.composite
def sequences(draw) -> dict[str, np.ndarray]:
    n = draw(st.integers(1, 6))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    widths = {name: len(columns) for name, columns in flame.WRITTEN.items()}
    widths["expression"] = draw(st.integers(1, 100))
    names = draw(st.sets(st.sampled_from(sorted(widths)), min_size=1))
    arrays = {name: rng.uniform(-0.4, 0.4, (n, widths[name])).astype("f4") for name in names}
    return arrays | {"valid": rng.random(n) < 0.7}


@QUICK
@given(arrays=sequences())
def test_what_is_written_is_read_as_it_was(arrays, tmp_path):
    first = taken(tmp_path, **arrays)
    if not first.motion["valid"].any():
        return  # nothing is told of such a take, so nothing can be written
    flame.write(tmp_path / "again.npz", first)
    again = flame.read(tmp_path / "again.npz", fps="25", face=None, bad_values="fail")
    pd.testing.assert_frame_equal(again.motion, first.motion)
    pd.testing.assert_frame_equal(again.coefficients["flame"], first.coefficients["flame"])
    assert again.origins == first.origins


@QUICK
@given(data=st.data())
def test_spoilt_bytes_give_our_error_or_a_take(data, tmp_path):
    content = bytearray((GOLDEN / "turns_left.npz").read_bytes())
    for place in data.draw(st.lists(st.integers(0, len(content) - 1), min_size=1, max_size=4)):
        content[place] = data.draw(st.integers(0, 255))
    path = tmp_path / "spoilt.npz"
    path.write_bytes(content)
    flame.holds(path)
    try:
        flame.read(path, fps="25", face=None, bad_values="mask")
    except BadFile as error:
        assert "\n" not in str(error)
