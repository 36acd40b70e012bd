import shutil

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mimeline.archives.torch_saved import read_saved, write_saved
from mimeline.errors import BadFile, NoSuchFile
from mimeline.face.rotations import turned
from mimeline.tables import AXES, COEFFICIENTS
from mimeline.tracking.formats import metrical_tracker
from mimeline.vocabulary import GAZE, HEAD

HEADLESS = [
    name
    for name in COEFFICIENTS["flame"].schema.names[2:]
    if not name.startswith(("head_", "neck_"))
]
LIDS = ["eyelid_left", "eyelid_right"]


def flame_rows(n: int, **columns) -> pd.DataFrame:
    """FLAME's coefficients at rest, but for those that are given."""
    return pd.DataFrame(0.0, index=range(n), columns=HEADLESS).assign(**columns)


def read(folder, bad_values="fail", face=None):
    return metrical_tracker.read(folder, fps="25", face=face, bad_values=bad_values)


def refusal(folder, bad_values="fail") -> str:
    with pytest.raises(BadFile) as caught:
        read(folder, bad_values)
    return str(caught.value)


def change(folder, number: int, **groups):
    """Change fields of a frame; None takes one away."""
    path = folder / "checkpoint" / f"{number:05d}.frame"
    content = read_saved(path, "")
    for group, fields in groups.items():
        if not isinstance(fields, dict):
            content[group] = fields
            continue
        merged = content[group] | fields
        content[group] = {name: value for name, value in merged.items() if value is not None}
    write_saved(path, content)


@pytest.fixture
def folder(tmp_path):
    """Six frames of a head that turns to its left while the jaw opens."""
    n = np.arange(6)
    rows = flame_rows(6, jaw_x=0.05 * n, left_eye_y=0.02 * n, right_eye_y=0.04 * n)
    metrical_tracker.write(tmp_path / "clip", rows, turned(0.1 * n, 0 * n, 0 * n))
    return tmp_path / "clip"


def test_head_gaze_jaw_and_lids_are_read_in_our_signs(folder):
    take = read(folder)
    motion = take.motion
    n = np.arange(6)
    np.testing.assert_allclose(motion["head_yaw_left"], 0.1 * n, atol=1e-6)
    np.testing.assert_allclose(motion["gaze_left"], 0.03 * n, atol=1e-6)
    np.testing.assert_allclose(motion[["head_pitch_up", "head_tilt_left", "gaze_up"]], 0, atol=1e-6)
    assert motion["valid"].all() and motion["jawOpen"].is_monotonic_increasing
    assert motion["jawOpen"].iloc[-1] > 0.5 and take.first_frame == 0
    np.testing.assert_allclose(take.coefficients["flame"]["jaw_x"], 0.05 * n, atol=1e-6)
    assert take.coefficients["flame"]["neck_x"].isna().all()


def test_origins_tell_where_head_and_gaze_come_from_and_what_is_not_measured(folder):
    origins = read(folder).origins
    assert origins["head_yaw_left"].text == "opencv.R, the head at rest"
    assert all(origins[name].measured for name in (*HEAD, *GAZE, "eyeBlinkLeft", "jawOpen"))
    assert not origins["browInnerUp"].measured


@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 4))
def test_what_is_written_is_read(tmp_path_factory, seed, n):
    rng, folder = np.random.default_rng(seed), tmp_path_factory.mktemp("take")
    rows = pd.DataFrame(rng.normal(0, 0.4, (n, len(HEADLESS))), columns=HEADLESS)
    rows[LIDS] = rng.random((n, 2))
    angles = rng.uniform(-0.9, 0.9, (3, n))
    valid = rng.random(n) < 0.7
    valid[-1] = True
    metrical_tracker.write(folder, rows, turned(*angles), valid)
    take = read(folder)
    assert take.motion["valid"].tolist() == valid.tolist()
    found = take.coefficients["flame"][HEADLESS][valid]
    np.testing.assert_allclose(found, rows[valid], atol=2e-6)
    np.testing.assert_allclose(
        take.motion[list(HEAD)].to_numpy().T[:, valid], angles[:, valid], atol=2e-6
    )
    assert take.motion[list(HEAD)][~valid].isna().all(axis=None)


def test_frames_may_lie_in_the_folder_itself(folder):
    assert metrical_tracker.holds(folder) and metrical_tracker.holds(folder / "checkpoint")
    pd.testing.assert_frame_equal(read(folder / "checkpoint").motion, read(folder).motion)


def test_other_folders_hold_no_frames(folder, tmp_path):
    (tmp_path / "notes.frame").write_text("")
    (tmp_path / "other").mkdir()
    for path in (tmp_path, tmp_path / "other", tmp_path / "none", tmp_path / "notes.frame"):
        assert not metrical_tracker.holds(path)


def test_a_hole_in_the_numbering_is_a_gap(folder):
    (folder / "checkpoint" / "00000.frame").unlink()
    (folder / "checkpoint" / "00003.frame").unlink()
    take = read(folder)
    assert take.motion["valid"].tolist() == [False, True, True, False, True, True]
    assert take.first_frame == 1
    assert take.coefficients["flame"].loc[3].isna().all()
    np.testing.assert_allclose(take.motion["head_yaw_left"].iloc[4], 0.4, atol=1e-6)


def test_a_file_that_breaks_off_fails_the_clip_or_is_a_gap(folder):
    last = folder / "checkpoint" / "00005.frame"
    last.write_bytes(last.read_bytes()[:2000])
    message = refusal(folder)
    assert "00005.frame" in message and "bad_values: mask" in message
    take = read(folder, "mask")
    assert take.motion["valid"].tolist() == [True] * 5 + [False]


def test_a_take_of_nothing_but_unreadable_files_says_what_is_wrong(folder):
    for file in (folder / "checkpoint").iterdir():
        file.write_bytes(b"<html>")
    assert "begins with b'<html>'" in refusal(folder, "mask")


@pytest.mark.parametrize("frame_id", ["00003", 3, "2.5", "", None])
def test_a_frame_of_another_number_than_its_name_is_refused(folder, frame_id):
    change(folder, 2, frame_id=frame_id)
    message = refusal(folder)
    assert "frame_id" in message and "expected 00002" in message and "begin_frames" in message


@pytest.mark.parametrize(
    "name", ["x.frame", "00001a.frame", "1.frame", "-1.frame", "9999999.frame"]
)
def test_a_name_that_is_no_number_or_one_twice_is_refused(folder, name):
    shutil.copy(folder / "checkpoint" / "00001.frame", folder / "checkpoint" / name)
    assert "expected each number below" in refusal(folder)


def test_an_empty_folder_and_a_missing_one_are_refused(tmp_path):
    assert "found no .frame file" in refusal(tmp_path)
    with pytest.raises(NoSuchFile):
        read(tmp_path / "none")


@pytest.mark.parametrize(
    ("groups", "place"),
    [
        ({"flame": {"exp": None}}, "flame.exp: found nothing"),
        ({"flame": {}, "camera": {"R": None}, "opencv": {"R": None}}, "opencv.R"),
        ({"flame": 3}, "flame.exp: found nothing"),
        ({"flame": {"exp": np.zeros((1, 101), np.float32)}}, "flame.exp: found (1, 101)"),
        ({"flame": {"exp": np.zeros((2, 100), np.float32)}}, "flame.exp: found (2, 100)"),
        ({"flame": {"exp": np.zeros((1, 0), np.float32)}}, "flame.exp: found (1, 0)"),
        ({"flame": {"exp": np.array([["a"] * 100], "S1")}}, "flame.exp: found no numbers"),
        ({"flame": {"exp": np.full((1, 100), np.nan)}}, "flame.exp: found a NaN"),
        ({"flame": {"jaw": np.zeros((1, 3))}}, "flame.jaw: found (1, 3)"),
        ({"flame": {"jaw": "text"}}, "flame.jaw: found no numbers"),
        ({"flame": {"jaw": np.full((1, 6), np.inf)}}, "flame.jaw: found a NaN or infinity"),
        ({"flame": {"jaw": np.zeros((1, 6))}}, "found a NaN"),
        ({"flame": {"eyes": np.zeros((1, 6))}}, "flame.eyes: found (1, 6)"),
        ({"flame": {"eyelids": np.zeros((2, 1))}}, "flame.eyelids: found (2, 1)"),
        ({"opencv": {"R": np.zeros((3, 4))}}, "opencv.R: found (3, 4)"),
        ({"opencv": {"R": np.ones((1, 3, 3))}, "camera": {"R": None}}, "opencv.R: found no rot"),
        ({"opencv": {"R": -np.eye(3)[None]}, "camera": {"R": None}}, "opencv.R: found no rotation"),
        ({"opencv": {"R": np.full((1, 3, 3), 1e300)}, "camera": {"R": None}}, "found no rotation"),
        ({"opencv": {"R": None}, "camera": {"R": np.zeros((1, 6))}}, "found no rotation"),
    ],
)
def test_a_frame_that_lacks_what_is_needed_fails_the_clip_or_is_a_gap(folder, groups, place):
    change(folder, 4, **groups)
    assert place in refusal(folder)
    assert read(folder, "mask").motion["valid"].tolist() == [True] * 4 + [False, True]


def test_what_a_tracker_does_not_give_is_not_measured(folder):
    for n in range(6):
        change(folder, n, flame={"eyes": None, "eyelids": None, "shape": None}, camera=None)
    take = read(folder)
    assert take.motion["valid"].all()
    assert take.motion[["gaze_left", "eyeBlinkLeft"]].isna().all(axis=None)
    assert not take.origins["gaze_left"].measured
    np.testing.assert_allclose(take.motion["head_yaw_left"].iloc[3], 0.3, atol=1e-6)


def test_fewer_expressions_leave_the_others_at_rest(folder):
    for n in range(6):
        change(folder, n, flame={"exp": np.full((1, 50), 0.5, np.float32)})
    flame = read(folder).coefficients["flame"]
    assert flame["exp049"].eq(0.5).all() and flame["exp050"].eq(0).all()


def pytorch3d_of(opencv):
    """The matrix of PyTorch3D's camera: for points as rows, x and y the other way round."""
    return opencv.T * [-1, -1, 1]


@pytest.mark.parametrize("which", ["camera", "opencv"])
def test_either_camera_tells_the_head(folder, which):
    both = read(folder).motion
    other = {"camera": "opencv", "opencv": "camera"}[which]
    for n in range(6):
        change(folder, n, **{other: {"R": None}})
    take = read(folder)
    assert take.origins["head_yaw_left"].text.startswith(f"{which}.R")
    np.testing.assert_allclose(take.motion[list(HEAD)], both[list(HEAD)], atol=1e-6)


def test_six_numbers_are_rows_and_not_columns(folder):
    """Columns, and points as columns, are another camera than opencv.R, and refused."""
    opencv = read_saved(folder / "checkpoint" / "00003.frame", "")["opencv"]["R"][0]
    matrix = pytorch3d_of(opencv)
    change(folder, 3, camera={"R": matrix[:2].reshape(1, 6)})
    assert read(folder).motion["valid"].all()
    change(folder, 3, camera={"R": matrix[:, :2].T.reshape(1, 6)})
    assert "camera.R: found another rotation than in opencv.R" in refusal(folder)


def test_a_frame_of_two_cameras_fails_the_clip_or_is_a_gap(folder):
    change(folder, 3, camera={"R": np.float32([[1, 0, 0, 0, 1, 0]])})
    assert "00003.frame" in refusal(folder)
    assert read(folder, "mask").motion["valid"].tolist() == [True] * 3 + [False, True, True]


def test_a_take_whose_frames_mostly_have_two_cameras_is_refused_whole(folder):
    """All but the first, in which the head is at rest: there rows and columns are the same."""
    for n in range(6):
        content = read_saved(folder / "checkpoint" / f"{n:05d}.frame", "")
        matrix = pytorch3d_of(content["opencv"]["R"][0])
        change(folder, n, camera={"R": matrix[:, :2].T.reshape(1, 6)})
    message = refusal(folder, "mask")
    assert "00001.frame" in message and "another rotation than in opencv.R" in message


@pytest.mark.parametrize("lacking", ["camera", "opencv"])
def test_a_head_that_turns_lifts_and_tilts_is_read_as_it_is_seen(folder, lacking):
    """The nose right of the middle of the picture and above it, the crown tilted about it."""
    turn, lift, tilt = 0.3, 0.2, 0.25
    right, up, near = np.float64([[1, 0, 0], [0, -1, 0], [0, 0, -1]])  # of OpenCV's camera
    aside = np.cos(turn) * near + np.sin(turn) * right  # the nose of the turned head
    nose = np.cos(lift) * aside + np.sin(lift) * up
    upright = np.cos(lift) * up - np.sin(lift) * aside  # the crown, without the tilt
    left = np.cross(upright, nose)
    crown = np.cos(tilt) * upright + np.sin(tilt) * left
    opencv = np.stack([np.cross(crown, nose), crown, nose], axis=1)
    told = {"opencv": opencv[None], "camera": pytorch3d_of(opencv)[:2].reshape(1, 6)}
    for n in range(6):
        change(folder, n, **{name: {"R": R} for name, R in (told | {lacking: None}).items()})
    found = read(folder).motion[list(HEAD)].iloc[0]
    np.testing.assert_allclose(found, [turn, lift, tilt], atol=1e-6)


def test_an_eye_that_looks_aside_and_up_is_read_as_it_looks(folder):
    aside, up = 0.3, 0.2
    look = np.array([np.sin(aside) * np.cos(up), np.sin(up), np.cos(aside) * np.cos(up)])
    top = np.array([-np.sin(aside) * np.sin(up), np.cos(up), -np.cos(aside) * np.sin(up)])
    eye = np.stack([np.cross(top, look), top, look], axis=1)[:2].ravel()
    change(folder, 5, flame={"eyes": np.concatenate([eye, eye])[None]})
    found = read(folder).motion[["gaze_left", "gaze_up"]].iloc[5]
    np.testing.assert_allclose(found, [aside, up], atol=1e-6)


def test_a_jaw_that_opens_turns_about_x_in_rows(folder):
    """As the tracker's own canonical mesh, whose jaw is opened by +12 degrees about x."""
    c, s = np.cos(np.radians(12)), np.sin(np.radians(12))
    opened = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    change(folder, 5, flame={"jaw": opened[:2].reshape(1, 6)})
    take = read(folder)
    found = take.coefficients["flame"][[f"jaw_{axis}" for axis in AXES]].iloc[5]
    np.testing.assert_allclose(found, [np.radians(12), 0, 0], atol=1e-6)
    assert take.motion["jawOpen"].iloc[5] > 0.5
    change(folder, 5, flame={"jaw": opened[:, :2].T.reshape(1, 6)})
    assert read(folder).motion["jawOpen"].iloc[5] <= 0


def test_six_numbers_that_are_not_quite_orthonormal_are_made_so(folder):
    change(folder, 5, flame={"jaw": np.array([[2, 0, 0, 0.1, 3, 0]], np.float32)})
    flame = read(folder).coefficients["flame"]
    np.testing.assert_allclose(flame[[f"jaw_{a}" for a in AXES]].iloc[5], 0, atol=1e-6)


def test_a_head_that_faces_away_is_refused(tmp_path):
    around = turned(np.full(3, 3.1), np.zeros(3), np.zeros(3))
    metrical_tracker.write(tmp_path, flame_rows(3), around)
    assert "looks away" in refusal(tmp_path)


def landmarks(folder, name="kpt", first=1, lost=(), points=68, n=6):
    (folder / name).mkdir()
    for number in range(first, first + n):
        shown = np.arange(2.0 * points).reshape(points, 2) + number
        np.save(folder / name / f"{number:05d}.npy", 0 * shown if number in lost else shown)


@pytest.mark.parametrize(("name", "points"), [("kpt", 68), ("kpt_dense", 478)])
def test_a_picture_without_landmarks_is_a_lost_frame_of_one_number_less(folder, name, points):
    landmarks(folder, name, lost=(3,), points=points)
    take = read(folder)
    assert take.motion["valid"].tolist() == [True, True, False, True, True, True]
    assert take.motion.loc[2, list(HEAD)].isna().all()
    assert ("landmarks" in take.coefficients) == (name == "kpt")


@pytest.mark.parametrize("first", [0, 1])
def test_landmarks_are_those_of_the_frame(folder, first):
    landmarks(folder, first=first, lost=(first + 1,))
    (folder / "kpt" / f"{first + 3:05d}.npy").unlink()
    table = read(folder).coefficients["landmarks"]
    assert list(table) == COEFFICIENTS["landmarks"].schema.names[2:]
    assert table["x_00"].dropna().to_dict() == {n: n + first for n in (0, 2, 4, 5)}
    assert table["y_67"].iloc[0] == 135 + first


def test_landmarks_are_found_beside_the_folder_checkpoint(folder):
    landmarks(folder, lost=(1,))
    assert not read(folder / "checkpoint").motion["valid"].iloc[0]


def test_landmarks_belong_to_a_gap_too(folder):
    landmarks(folder)
    (folder / "checkpoint" / "00002.frame").unlink()
    table = read(folder).coefficients["landmarks"]
    assert len(table) == 6 and table.loc[2].isna().all() and table.loc[3, "x_00"] == 4


@pytest.mark.parametrize(("name", "points"), [("kpt", 68), ("kpt_dense", 478)])
@pytest.mark.parametrize(
    ("first", "n", "found"),
    [
        (1, 7, "landmarks up to frame 6"),  # the tracker skipped one, or was stopped
        (0, 7, "landmarks up to frame 6"),
        (3, 6, "landmarks up to frame 7"),  # the skipped ones taken away, the others not renumbered
        (1, 4, "2 missing"),
        (1, 0, "6 missing"),
    ],
)
def test_landmarks_of_another_numbering_are_refused(folder, name, points, first, n, found):
    landmarks(folder, name, first=first, n=n, points=points)
    for bad_values in ("fail", "mask"):
        message = refusal(folder, bad_values)
        assert found in message and "begin_frames" in message


@pytest.mark.parametrize(
    "bad",
    [
        np.array([{}] * 68),
        np.zeros((67, 2)),
        np.zeros((68, 4)),
        np.full((68, 2), np.nan),
        np.zeros((68, 2), "S1"),
        b"\x93NUMPY\x01\x00",
        b"",
        b"\x93NUMPY\x01\x00v\x00{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000,)}"
        + b" " * 45
        + b"\n",
    ],
    ids=range(8),
)
def test_landmarks_that_are_none_fail_the_clip_or_are_left_out(folder, bad):
    landmarks(folder)
    path = folder / "kpt" / "00004.npy"
    if isinstance(bad, bytes):
        path.write_bytes(bad)
    else:
        np.save(path, bad, allow_pickle=True)
    assert "00004.npy" in refusal(folder)
    take = read(folder, "mask")
    assert take.motion["valid"].all()
    assert take.coefficients["landmarks"].isna().all(axis=1).tolist() == [False] * 3 + [
        True,
        False,
        False,
    ]


def test_a_written_take_has_the_layout_that_the_tracker_saves(folder):
    content = read_saved(folder / "checkpoint" / "00003.frame", "")
    shapes = {
        group: {name: values.shape for name, values in content[group].items()}
        for group in ("flame", "camera", "opencv")
    }
    assert shapes == {
        "flame": {
            "exp": (1, 100),
            "shape": (1, 300),
            "tex": (1, 140),
            "sh": (1, 9, 3),
            "eyes": (1, 12),
            "eyelids": (1, 2),
            "jaw": (1, 6),
        },
        "camera": {"R": (1, 6), "t": (1, 3), "fl": (1, 1), "pp": (1, 2)},
        "opencv": {"R": (1, 3, 3), "t": (1, 3), "K": (1, 3, 3)},
    }
    assert content["frame_id"] == "00003" and content["img_size"].tolist() == [512, 512]
    assert all(v.dtype == np.float32 for group in shapes for v in content[group].values())
    np.testing.assert_array_equal(
        content["opencv"]["K"][0], [[2500, 0, 256], [0, 2500, 256], [0, 0, 1]]
    )
