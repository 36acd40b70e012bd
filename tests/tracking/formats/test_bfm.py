import tracemalloc
from pathlib import Path

import cv2
import numpy as np
import pandas as pd
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.io import savemat

from mimeline.errors import BadFile, NoSuchFile
from mimeline.face.rotations import turned
from mimeline.tables import COEFFICIENTS
from mimeline.tracking.formats import bfm
from mimeline.tracking.take import Take
from mimeline.vocabulary import EXPRESSIONS, HEAD

LATER = 6  # frames between two pictures


@pytest.fixture
def coeff() -> np.ndarray:
    """Four frames of a head that turns about y."""
    rows = np.random.default_rng(0).normal(scale=0.3, size=(4, 257)).astype("f4")
    rows[:, 224:227] = [[0, angle, 0] for angle in (0, 0.1, 0.2, 0.3)]
    return rows


def taken(folder: Path, coeff, bad_values: str = "fail", **more) -> Take:
    savemat(folder / "take.mat", {"coeff": coeff, **more})
    return bfm.read(folder / "take.mat", fps="25", face=None, bad_values=bad_values)


def test_the_columns_are_expression_angles_and_translation(tmp_path, coeff):
    table = taken(tmp_path, coeff, transform_params=np.ones((4, 5))).coefficients["bfm"]
    assert list(table) == COEFFICIENTS["bfm"].schema.names[2:]
    np.testing.assert_array_equal(table.filter(like="exp"), coeff[:, 80:144])
    np.testing.assert_array_equal(table.filter(like="angle"), coeff[:, 224:227])
    np.testing.assert_array_equal(table.filter(like="translation"), coeff[:, 254:257])


def test_without_the_users_model_no_arkit_channel_is_measured(tmp_path, coeff):
    take = taken(tmp_path, coeff)
    assert take.motion[list(EXPRESSIONS)].isna().all(axis=None)
    assert not any(take.origins[name].measured for name in EXPRESSIONS)
    assert all(take.origins[name].measured for name in HEAD)
    np.testing.assert_allclose(take.motion["head_yaw_left"], [0, 0.1, 0.2, 0.3], atol=1e-6)


def test_a_frame_with_a_number_that_is_none_fails_or_is_masked(tmp_path, coeff):
    coeff[2, 100] = np.nan
    with pytest.raises(BadFile, match="row 2"):
        taken(tmp_path, coeff)
    take = taken(tmp_path, coeff, "mask")
    assert take.motion["valid"].tolist() == [True, True, False, True]
    assert take.motion.loc[2, "head_yaw_left":].isna().all()
    assert take.coefficients["bfm"].loc[2].isna().all()


def test_a_row_of_zeros_is_a_frame_without_a_face(tmp_path, coeff):
    coeff[1] = 0
    assert taken(tmp_path, coeff).motion["valid"].tolist() == [True, False, True, True]


@pytest.mark.parametrize(
    ("place", "value", "found"),
    [
        ((1, 225), 20.0, "radians"),
        ((1, 90), 1e9, "coefficients within"),
        ((3, 255), -3e4, "within"),
    ],
)
def test_degrees_and_what_is_no_coefficient_are_refused(tmp_path, coeff, place, value, found):
    coeff[place] = value
    with pytest.raises(BadFile, match=found):
        taken(tmp_path, coeff)


@pytest.mark.parametrize("shape", [(0, 257), (4, 70), (257, 1), (2, 2, 257)])
def test_other_shapes_are_refused(tmp_path, shape):
    with pytest.raises(BadFile, match="coeff"):
        taken(tmp_path, np.zeros(shape))
    assert not bfm.holds(tmp_path / "take.mat") or shape == (0, 257)


def test_what_holds_asks_does_not_unpack_the_numbers(tmp_path):
    savemat(tmp_path / "long.mat", {"coeff": np.ones((10_000, 257))}, do_compression=True)
    tracemalloc.start()
    assert bfm.holds(tmp_path / "long.mat")
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 200_000


def test_a_head_turns_about_x_then_y_then_z_of_the_camera(tmp_path, coeff):
    """Two angles at once, of which the second turns where the first has brought nose and crown."""
    c, s = np.cos(0.5), np.sin(0.5)
    for angles, nose, crown in (
        ((0.5, 0.5, 0), (s * c, -s, c * c), (s * s, c, s * c)),  # down, then both to the right
        ((0.5, 0, 0.5), (s * s, -s * c, c), (-s * c, c * c, s)),  # down, then counter-clockwise
        ((0, 0.5, 0.5), (s * c, s * s, c), (-s, c, 0)),  # to the right, then counter-clockwise
    ):
        coeff[:, 224:227] = angles
        motion = taken(tmp_path, coeff).motion
        R = turned(*(motion[name].to_numpy() for name in HEAD))[0]
        np.testing.assert_allclose(R[:, 2], nose, atol=1e-5)
        np.testing.assert_allclose(R[:, 1], crown, atol=1e-5)


@pytest.mark.parametrize("content", ["text", {"a": 1}, np.array(["a", 1], dtype=object)])
def test_what_is_no_array_is_refused(tmp_path, content):
    with pytest.raises(BadFile, match="coeff"):
        taken(tmp_path, content)


def test_files_that_are_not_there_or_no_mat_are_told_apart(tmp_path):
    with pytest.raises(NoSuchFile):
        bfm.read(tmp_path / "none.mat", fps="25", face=None, bad_values="fail")
    (tmp_path / "text.mat").write_text("coeff")
    with pytest.raises(BadFile):
        bfm.read(tmp_path / "text.mat", fps="25", face=None, bad_values="fail")
    assert not bfm.holds(tmp_path / "none.mat")
    assert not bfm.holds(tmp_path / "text.mat")


@settings(
    max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    values=st.lists(
        st.tuples(
            st.integers(0, 3),
            st.integers(0, 256),
            st.floats(width=32) | st.sampled_from([np.nan, np.inf, -np.inf, 1e38]),
        ),
        max_size=6,
    ),
    bad_values=st.sampled_from(["fail", "mask"]),
)
def test_any_numbers_give_a_take_or_our_error(tmp_path, coeff, values, bad_values):
    coeff = coeff.copy()
    for row, column, value in values:
        coeff[row, column] = value
    try:
        take = taken(tmp_path, coeff, bad_values)
    except BadFile:
        return
    told = take.motion.loc[take.motion["valid"], list(HEAD)]
    assert np.isfinite(told).all(axis=None) and (told.abs() <= np.pi + 1e-6).all(axis=None)


def test_the_angles_turn_the_way_that_faces_move_in_real_videos(real_data):
    """Optical flow inside the face against what the coefficients say of the same frames.

    The face's flow is fitted by a shift, a plane and the flow of a bulge whose middle is nearest to
    the camera. A turn to the left moves the middle to the right of the picture against the rim, by
    its depth times the angle; a lift moves it up; a tilt to the left shoulder turns the plane
    clockwise by the angle itself.
    """
    folder = real_data / "dreamtalk"
    told, seen = [], []
    for path in sorted(folder.glob("*.mat")):
        motion = bfm.read(path, fps="25", face=None, bad_values="fail").motion
        pictures = _grey(path.with_suffix(".mp4"))
        assert len(pictures) == len(motion)
        for start in range(0, len(pictures) - LATER, LATER):
            change = motion.loc[start + LATER, list(HEAD)] - motion.loc[start, list(HEAD)]
            told.append(change.astype(float))
            seen.append(_movement(pictures[start], pictures[start + LATER]))
    if not told:
        pytest.skip(f"no videos with coefficients in {folder}")
    told, seen = pd.DataFrame(told), pd.DataFrame(seen, columns=list(HEAD))
    for name, least in zip(HEAD, (0.6, 0.5, 0.75), strict=True):
        assert np.corrcoef(told[name], seen[name])[0, 1] > least
        assert 0.6 < np.polyfit(told[name], seen[name], 1)[0] < 1.2


def _grey(video: Path) -> list[np.ndarray]:
    reader, pictures = cv2.VideoCapture(str(video)), []
    while (read := reader.read())[0]:
        pictures.append(cv2.cvtColor(read[1], cv2.COLOR_BGR2GRAY))
    return pictures


def _movement(before: np.ndarray, after: np.ndarray) -> tuple[float, float, float]:
    """Turn to the left, up and tilt to the left in radians, of a face of 160 by 124 pixels."""
    rows, columns = np.mgrid[: before.shape[0], : before.shape[1]].astype(float)
    x, y = (columns - 128) / 62, (rows - 135) / 80
    face = (x**2 + y**2 < 1) & ~((y > 0.25) & (abs(x) < 0.6))  # without the mouth
    bulge = 60 * np.sqrt(np.clip(1 - x**2 - y**2, 0, None))  # pixels
    design = np.stack([np.ones(face.sum()), columns[face], rows[face], bulge[face]], 1)
    flow = cv2.DISOpticalFlow_create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM).calc(before, after, None)
    (_, _, right_down, right), (_, down_right, _, down) = np.linalg.lstsq(design, flow[face])[0].T
    return right, -down, (down_right - right_down) / 2
