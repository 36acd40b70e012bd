import numpy as np
import pandas as pd
import pytest
from scipy.spatial import cKDTree

from mimeline.face.load import load_face
from mimeline.face.motion import LOOK_DOWN, LOOK_SIDEWAYS, perform, pose
from mimeline.vocabulary import CHANNELS, EXPRESSIONS

NOSE, CROWN, LEFT_EAR = np.eye(3)[[2, 1, 0]]


def head(**motion):
    return pd.DataFrame({name: [value] for name, value in motion.items()})


def turned(face, direction, **motion):
    return pose(face, head(**motion)).head[0] @ direction


def test_turning_left_brings_the_nose_to_the_left(ball_face):
    x, y, _ = turned(ball_face, NOSE, head_yaw_left=0.3)
    assert x == pytest.approx(np.sin(0.3)) and y == pytest.approx(0)


def test_pitching_up_raises_the_nose(ball_face):
    x, y, _ = turned(ball_face, NOSE, head_pitch_up=0.3)
    assert y == pytest.approx(np.sin(0.3)) and x == pytest.approx(0)


def test_tilting_left_lowers_the_left_ear_and_moves_the_crown_to_the_left(ball_face):
    assert turned(ball_face, LEFT_EAR, head_tilt_left=0.3)[1] == pytest.approx(-np.sin(0.3))
    assert turned(ball_face, CROWN, head_tilt_left=0.3)[0] == pytest.approx(np.sin(0.3))


def test_a_turned_head_lifts_and_tilts_about_its_own_axes(ball_face):
    x, y, z = turned(ball_face, NOSE, head_yaw_left=np.pi / 2, head_pitch_up=0.3)
    assert (x, y) == pytest.approx((np.cos(0.3), np.sin(0.3))) and z == pytest.approx(0, abs=1e-6)


def test_both_eyes_follow_a_measured_gaze(ball_face):
    posed = pose(ball_face, head(gaze_left=0.2, gaze_up=0.1, eyeLookOutRight=1.0))
    np.testing.assert_array_equal(posed.left_eye, posed.right_eye)
    x, y, _ = posed.left_eye[0] @ NOSE
    assert x == pytest.approx(np.sin(0.2) * np.cos(0.1)) and y == pytest.approx(np.sin(0.1))


def test_eyes_without_a_gaze_turn_by_their_own_look(ball_face):
    posed = pose(ball_face, head(gaze_left=np.nan, eyeLookOutLeft=1.0, eyeLookDownRight=1.0))
    assert (posed.left_eye[0] @ NOSE)[0] == pytest.approx(np.sin(LOOK_SIDEWAYS))
    assert (posed.right_eye[0] @ NOSE)[1] == pytest.approx(-np.sin(LOOK_DOWN))
    inwards = pose(ball_face, head(eyeLookInLeft=1.0)).left_eye[0] @ NOSE
    assert inwards[0] == pytest.approx(-np.sin(LOOK_SIDEWAYS))


def test_what_was_not_measured_rests(ball_face):
    motion = pd.DataFrame({"jawOpen": [0.5, None], "clip_id": ["a", "a"], "frame": [0, 1]})
    posed = pose(ball_face, motion)
    np.testing.assert_array_equal(posed.coefficients, [[0.5, 0, 0, 0], [0, 0, 0, 0]])
    np.testing.assert_array_equal(posed.head, np.tile(np.eye(3), (2, 1, 1)))


def test_a_channel_drives_both_halves_of_its_shape(ball_face):
    np.testing.assert_allclose(
        pose(ball_face, head(browInnerUp=0.7)).coefficients, [[0, 0, 0.7, 0.7]], rtol=1e-6
    )


def test_a_nullable_column_of_a_table_is_read(ball_face):
    motion = pd.DataFrame({"jawOpen": pd.array([0.5, pd.NA], dtype="Float32")})
    np.testing.assert_array_equal(pose(ball_face, motion).coefficients[:, 0], [0.5, 0])


def test_an_eyeball_turns_in_the_head_and_in_place(ball_face):
    ball = ball_face.skin[:, 1] == 1
    rest, looking, both = perform(
        ball_face, pd.DataFrame({"gaze_left": [0, 0.5, 0.5], "head_yaw_left": [0, 0, 0.4]})
    )
    np.testing.assert_allclose(looking[ball].mean(0), rest[ball].mean(0), atol=1e-6)
    assert np.abs(looking[ball] - rest[ball]).max() > 0.005
    np.testing.assert_array_equal(
        looking[~ball & (ball_face.skin[:, 2] == 0)], rest[~ball & (ball_face.skin[:, 2] == 0)]
    )
    assert both[ball].mean(0)[0] > rest[ball].mean(0)[0]


def test_a_table_without_rows_gives_no_frames(ball_face):
    assert perform(ball_face, pd.DataFrame({"jawOpen": []})).shape == (0, *ball_face.neutral.shape)


def motion_and_its_mirror(seed):
    rng = np.random.default_rng(seed)
    values = {
        name: rng.random(4) if name in EXPRESSIONS else rng.normal(0, 0.2, 4) for name in CHANNELS
    }
    mirrored = {
        name: channel.mirror_sign * values[channel.mirror] for name, channel in CHANNELS.items()
    }
    return pd.DataFrame(values), pd.DataFrame(mirrored)


@pytest.fixture(scope="module")
def ict(real_data):
    return load_face(real_data / "face" / "ict_facekit_compact.npz")


@pytest.mark.parametrize(("model", "share", "within"), [("embedded", 1, 1e-6), ("ict", 0.99, 1e-3)])
def test_mirrored_motion_gives_the_mirrored_face(model, share, within, request):
    """share of the vertices that must lie where they should, within metres."""
    face = load_face(None) if model == "embedded" else request.getfixturevalue("ict")
    flip = np.float32([-1, 1, 1])
    distance, partner = cKDTree(face.neutral).query(face.neutral * flip)
    paired = distance < 1e-5
    assert paired.mean() >= share
    motion, mirrored = motion_and_its_mirror(0)
    expected = perform(face, motion)[:, partner] * flip
    off = np.linalg.norm(perform(face, mirrored) - expected, axis=2)[:, paired]
    assert (off < within).mean() >= share
