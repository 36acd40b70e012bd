import numpy as np
import pandas as pd
import pytest
from scipy.io import savemat
from scipy.spatial.transform import Rotation

from mimeline import tables
from mimeline.errors import BadFile
from mimeline.face.embedded import anatomy, embedded_face
from mimeline.face.embedded.mesh import build
from mimeline.face.formats.shapes import to_npz
from mimeline.face.motion import LOOK_DOWN, LOOK_SIDEWAYS, LOOK_UP
from mimeline.face.retarget import LEAST_QUALITY
from mimeline.face.rotations import turned
from mimeline.toy import frame_files
from mimeline.tracking.formats.arkit import JAW_OPEN, JAW_SIDEWAYS, from_bfm, from_flame
from mimeline.vocabulary import CHANNELS, EXPRESSIONS, HEAD

MIXED = list(frame_files.MIXED)  # channels that expressions tell
FLAME = tables.COEFFICIENTS["flame"].schema.names[2:]
JOINTS = ("head", "neck", "jaw", "left_eye", "right_eye")


@pytest.fixture(scope="module")
def face_file(tmp_path_factory):
    """A face in FLAME's layout that is not FLAME."""
    path = tmp_path_factory.mktemp("face") / "face_model.npz"
    frame_files.write_face(path)
    return path


def at_rest(n: int = 3, **columns) -> pd.DataFrame:
    return pd.DataFrame(0.0, index=range(n), columns=FLAME).assign(**columns)


def turning(joint: str, yaw_left: float = 0, pitch_up: float = 0) -> pd.DataFrame:
    """Rows of a joint that turns ever further."""
    share = np.linspace(0, 1, 3)
    turns = turned(yaw_left * share, pitch_up * share, 0 * share)
    vectors = Rotation.from_matrix(turns).as_rotvec()
    return pd.DataFrame(vectors, columns=[f"{joint}_{axis}" for axis in tables.AXES])


def motion(n: int = 40, seed: int = 0) -> pd.DataFrame:
    """Rows of table motion with a few channels active in each."""
    rng = np.random.default_rng(seed)
    rows = pd.DataFrame(0.0, index=range(n), columns=list(CHANNELS))
    values = rng.uniform(0, 1, (n, len(EXPRESSIONS))) * (rng.random((n, len(EXPRESSIONS))) < 0.1)
    rows[list(EXPRESSIONS)] = values
    return rows


def test_jaw_lids_and_eyes_tell_their_channels_without_a_face():
    rows = at_rest(eyelid_left=[0, 0.5, 1]).assign(**turning("jaw", 0.07, -0.29))
    rows = rows.assign(**turning("left_eye", 0.3, -0.2), **turning("right_eye", 0.1, -0.2))
    channels, origins = from_flame(rows, None)
    last = channels.iloc[-1]
    assert last["eyeBlinkLeft"] == 1 and last["eyeBlinkRight"] == 0
    assert last["jawOpen"] == pytest.approx(1, abs=0.01)
    assert last["jawLeft"] == pytest.approx(0.07 / JAW_SIDEWAYS, abs=0.01)
    assert last["jawRight"] == 0
    assert last["gaze_left"] == pytest.approx(0.2) and last["gaze_up"] == pytest.approx(-0.2)
    assert last["eyeLookOutLeft"] == pytest.approx(0.3 / LOOK_SIDEWAYS)
    assert last["eyeLookInRight"] == pytest.approx(0.1 / LOOK_SIDEWAYS)
    assert last["eyeLookDownLeft"] == pytest.approx(0.2 / LOOK_DOWN)
    assert last[["eyeLookInLeft", "eyeLookOutRight", "eyeLookUpLeft", "eyeLookUpRight"]].eq(0).all()
    assert all(origins[name].measured for name in channels)
    unmeasured = {name for name in EXPRESSIONS if not origins[name].measured}
    assert unmeasured == set(MIXED)
    assert {origins[name].text for name in unmeasured} == {
        "not measured, since no face model was given"
    }


def test_eyes_that_look_up_do_so_by_their_own_slope():
    rows = at_rest().assign(**turning("left_eye", 0, 0.2), **turning("right_eye", 0, 0.2))
    channels, _ = from_flame(rows, None)
    assert channels["eyeLookUpRight"].iloc[-1] == pytest.approx(0.2 / LOOK_UP)


def test_the_head_is_left_to_the_reader():
    rows = at_rest().assign(**turning("head", 0.5, 0.2), **turning("neck", 0.1, 0.1))
    channels, origins = from_flame(rows, None)
    assert not set(HEAD) & (set(channels) | set(origins))
    np.testing.assert_array_equal(channels, 0)


def test_the_jaws_angles_are_those_that_fit_the_embedded_faces_jaw_best():
    face, mesh = embedded_face(), build()
    arms = mesh.points - anatomy.HINGE_AT  # centimetres
    for name, (a, b), angle in (("jawOpen", (1, 2), JAW_OPEN), ("jawLeft", (2, 0), JAW_SIDEWAYS)):
        moved = (
            100 * face.shapes[face.shape_names.index(name)] / np.maximum(mesh.jaw, 0.05)[:, None]
        )
        there = arms + moved
        turn = mesh.jaw @ (arms[:, a] * there[:, b] - arms[:, b] * there[:, a])
        stay = mesh.jaw @ (arms[:, a] * there[:, a] + arms[:, b] * there[:, b])
        assert np.arctan2(turn, stay) == pytest.approx(angle, rel=0.05)


def test_a_mirrored_face_swaps_sides():
    rows = at_rest(eyelid_left=[0, 0.5, 1]).assign(**turning("jaw", 0.1, -0.1))
    rows = rows.assign(**turning("left_eye", 0.3, 0.1), **turning("right_eye", 0.1, 0.1))
    twin = rows.copy()
    for column in FLAME:  # a rotation about y or z turns round, and the eyes change places
        source = column.replace("left", "LEFT").replace("right", "left").replace("LEFT", "right")
        turns_round = column.startswith(JOINTS) and column[-2:] in ("_y", "_z")
        twin[column] = rows[source] * (-1 if turns_round else 1)
    channels, _ = from_flame(rows, None)
    mirrored, _ = from_flame(twin, None)
    for name in channels:
        partner = CHANNELS[name]
        wanted = partner.mirror_sign * channels[partner.mirror]
        np.testing.assert_allclose(mirrored[name], wanted, atol=1e-6)


def test_expressions_come_back_as_the_channels_that_they_were_made_of(face_file):
    wanted = motion()
    channels, origins = from_flame(frame_files.coefficients(wanted), face_file)
    for name in [*MIXED, "jawOpen", "eyeBlinkLeft", "eyeBlinkRight"]:
        np.testing.assert_allclose(channels[name], wanted[name], atol=1e-3, err_msg=name)
    assert {origins[name].text for name in MIXED} == {"expression through face_model.npz"}
    assert min(origins[name].quality for name in MIXED) > 0.99
    assert origins["jawOpen"].quality is None


def test_the_jaw_and_the_eyes_change_no_other_channel(face_file):
    still = frame_files.coefficients(motion(3))
    moving = still.assign(**turning("jaw", 0.1, -0.3), **turning("left_eye", 0.2, 0.1))
    (before, _), (after, _) = (from_flame(rows, face_file) for rows in (still, moving))
    pd.testing.assert_frame_equal(before[MIXED], after[MIXED])


def test_a_frame_without_numbers_has_none(face_file):
    rows = frame_files.coefficients(motion(5))
    rows.iloc[[1, 3]] = np.nan
    channels, _ = from_flame(rows, face_file)
    assert channels.isna().all(axis=1).tolist() == [False, True, False, True, False]
    assert channels.iloc[[0, 2, 4]].notna().all(axis=None)


def test_what_the_tracker_does_not_tell_comes_through_the_face_or_is_not_possible(face_file):
    silent = ["eyelid_left", "eyelid_right", *(f"{j}_{a}" for j in JOINTS for a in tables.AXES)]
    rows = (
        frame_files.coefficients(motion())
        .reindex(columns=FLAME)
        .assign(**dict.fromkeys(silent, np.nan))
    )
    channels, origins = from_flame(rows, face_file)
    for name in ("jawLeft", "jawRight"):  # which this face's expressions cannot show
        assert name not in channels and not origins[name].measured
        assert "face_model.npz" in origins[name].text
        assert origins[name].quality < LEAST_QUALITY
    assert origins["eyeBlinkLeft"].text == "expression through face_model.npz"
    for name in ("gaze_left", "eyeLookInLeft"):
        assert name not in channels and origins[name].text == "the eyes' rotations are not given"


def test_no_expressions_are_not_neutral_ones(face_file):
    rows = at_rest()
    rows[[name for name in FLAME if name.startswith("exp")]] = np.nan
    channels, origins = from_flame(rows, face_file)
    assert not set(MIXED) & set(channels)
    assert origins["mouthFunnel"].text == "not measured, since expressions are not given"


def test_a_file_of_another_model_is_refused(tmp_path):
    to_npz(embedded_face(), tmp_path / "named.npz")
    with pytest.raises(BadFile, match="the face model that the coefficients are of"):
        from_flame(at_rest(), tmp_path / "named.npz")


def test_a_file_without_a_surface_is_refused(face_file, tmp_path):
    with np.load(face_file) as file:
        arrays = dict(file)
    np.savez(tmp_path / "points.npz", **arrays | {"f": np.zeros((0, 3), np.uint32)})
    with pytest.raises(BadFile, match="without a surface"):
        from_flame(at_rest(), tmp_path / "points.npz")


def test_more_expressions_than_the_face_has_are_refused(face_file, tmp_path):
    with np.load(face_file) as file:
        arrays = dict(file)
    np.savez(tmp_path / "few.npz", **arrays | {"shapedirs": arrays["shapedirs"][..., :350]})
    assert from_flame(at_rest(exp010=1.0), tmp_path / "few.npz")
    with pytest.raises(BadFile, match="50 expressions"):
        from_flame(at_rest(exp060=1.0), tmp_path / "few.npz")


def test_the_basel_face_model_tells_no_eyes_and_through_its_file_the_rest(tmp_path):
    face = embedded_face()
    shown = [name for name in EXPRESSIONS if name not in ("tongueOut",)]
    bases = np.zeros((64, face.neutral.size), np.float32)
    bases[: len(shown)] = face.shapes[[face.shape_names.index(name) for name in shown]].reshape(
        len(shown), -1
    )
    arrays = {
        "meanshape": 10 * face.neutral.reshape(1, -1),
        "idBase": np.zeros((face.neutral.size, 1)),
        "exBase": 10 * bases.T,
        "tri": face.triangles + 1.0,
        "keypoints": face.landmarks[None] + 1.0,
    }
    savemat(tmp_path / "BFM_model_front.mat", arrays)
    rows = pd.DataFrame(0.0, index=range(3), columns=[f"exp{n:03d}" for n in range(64)])
    rows[f"exp{shown.index('eyeBlinkLeft'):03d}"] = [0, 0.5, 1]
    rows[f"exp{shown.index('mouthSmileRight'):03d}"] = [0, 1, 0.5]
    channels, origins = from_bfm(rows, tmp_path / "BFM_model_front.mat")
    np.testing.assert_allclose(channels["eyeBlinkLeft"], [0, 0.5, 1], atol=0.01)
    np.testing.assert_allclose(channels["mouthSmileRight"], [0, 1, 0.5], atol=0.01)
    for name in ("tongueOut", "eyeLookUpLeft", "gaze_left"):
        assert name not in channels and not origins[name].measured
    channels, origins = from_bfm(rows, None)
    assert not len(channels.columns) and origins["jawOpen"].text.endswith("no face model was given")


def test_what_would_have_told_a_channel_is_said_where_nothing_does():
    rows = at_rest()
    rows[[name for name in FLAME if name.startswith(("jaw", "eyelid"))]] = np.nan
    _, origins = from_flame(rows, None)
    assert origins["jawOpen"].text == "no jaw rotation is given, and no face model was given"
    assert origins["eyeBlinkLeft"].text == "no eyelids are given, and no face model was given"
    assert origins["jawForward"].text == "not measured, since no face model was given"


def test_a_jaw_that_turns_the_wrong_way_or_far_is_seen_as_it_does():
    """So that what looks for values out of range finds them."""
    rows = at_rest(eyelid_left=[0, -0.4, 1.6]).assign(**turning("jaw", 0.2, 0.2))
    channels, _ = from_flame(rows, None)
    assert channels["eyeBlinkLeft"].tolist() == [0, -0.4, 1.6]
    assert channels["jawOpen"].iloc[-1] == pytest.approx(-0.2 / JAW_OPEN, abs=0.02)
    assert channels["jawLeft"].iloc[-1] == pytest.approx(0.2 / JAW_SIDEWAYS, abs=0.05)
    assert channels["jawRight"].iloc[-1] == 0
    far, _ = from_flame(at_rest().assign(**turning("jaw", 0, -1.2)), None)
    assert far["jawOpen"].iloc[-1] == 2
