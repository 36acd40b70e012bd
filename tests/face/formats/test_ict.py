import numpy as np
import pandas as pd
import pytest

from mimeline.errors import BadFile
from mimeline.face.formats import ict
from mimeline.face.load import load_face
from mimeline.face.motion import pose
from mimeline.face.render import Camera, draw
from mimeline.vocabulary import EXPRESSIONS


@pytest.fixture(scope="module")
def packed(real_data):
    return real_data / "face" / "ict_facekit_compact.npz"


@pytest.fixture(scope="module")
def arrays(packed):
    with np.load(packed) as file:
        return {name: file[name] for name in file.files}


@pytest.fixture(scope="module")
def face(packed):
    return load_face(packed)


def offsets(face, name):
    return face.shapes[face.shape_names.index(name)]


def test_its_shapes_are_the_channels(face):
    halves = {"browInnerUp_L", "browInnerUp_R", "cheekPuff_L", "cheekPuff_R"}
    missing = set(EXPRESSIONS) - set(face.shape_names)
    assert missing == {"browInnerUp", "cheekPuff", "tongueOut"} and halves <= set(face.shape_names)
    coefficients = pose(face, pd.DataFrame({"cheekPuff": [0.5]})).coefficients[0]
    driven = [n for n, c in zip(face.shape_names, coefficients, strict=True) if c == 0.5]
    assert driven == ["cheekPuff_L", "cheekPuff_R"]


def test_its_left_is_the_subjects_left_and_its_unit_the_metre(face):
    for name, sign in (("eyeBlinkLeft", 1), ("mouthSmileRight", -1), ("browInnerUp_L", 1)):
        moved = np.linalg.norm(offsets(face, name), axis=1)
        assert sign * (moved @ face.neutral[:, 0]) / moved.sum() > 0.01
    assert 0.3 < np.ptp(face.neutral[:, 1]) < 0.4
    assert face.neutral[face.landmarks[30], 2] > 0.1  # the nose points forward


def test_landmarks_run_from_the_subjects_right_and_the_lips_are_below_the_nose(face):
    points = face.landmarks_at(face.neutral)
    assert points[0, 0] < -0.05 and points[16, 0] > 0.05
    assert points[36, 0] < points[39, 0] < points[42, 0] < points[45, 0]
    assert points[51, 1] < points[33, 1] < points[27, 1]
    assert points[8, 1] == points[:, 1].min()


def test_no_channel_moves_an_eyeball_so_that_gaze_is_applied_once(face):
    for ball in ict.BALLS.values():
        for name in face.shape_names:
            if not name.startswith("PupilDilate"):
                assert np.abs(offsets(face, name)[ball]).max() < 1e-6


def test_what_would_hide_the_eyes_is_not_drawn(face):
    assert face.triangles.max() < ict.N_DRAWN
    picture = draw(face, face.neutral, Camera.framing(face, 256))
    for ball in ict.BALLS.values():
        centre = (face.neutral[ball].min(0) + face.neutral[ball].max(0)) / 2
        column, row = Camera.framing(face, 256).project(centre + np.float32([0, 0, 0.015]))
        around = picture[int(row) - 3 : int(row) + 4, int(column) - 3 : int(column) + 4]
        assert around.sum(-1).min() < 120  # a pupil


def test_a_blink_hides_the_pupils(face):
    blink = np.zeros((1, len(face.shape_names)))
    for name in ("eyeBlinkLeft", "eyeBlinkRight"):
        blink[0, face.shape_names.index(name)] = 1
    camera = Camera.framing(face, 256)
    eyes = slice(90, 125), slice(80, 176)
    rest, shut = (
        draw(face, v, camera)[eyes].sum(-1) for v in (face.neutral, face.vertices(blink)[0])
    )
    assert (rest < 150).sum() > 10 and (shut < 150).sum() == 0


def test_the_whole_head_follows_an_identity(face):
    person = face.of({"identity000": 2.0, "identity003": -2.0})
    moved = person.neutral - face.neutral
    edges = face.triangles[:, [0, 1]]
    border = (edges.min(1) < ict.N_FACE) & (edges.max(1) >= ict.N_FACE)
    across = moved[edges[border, 0]] - moved[edges[border, 1]]
    assert np.linalg.norm(moved[: ict.N_FACE], axis=1).max() > 0.01
    assert np.linalg.norm(across, axis=1).max() < 0.003  # nothing is torn
    for ball in ict.BALLS.values():
        assert np.ptp(moved[ball], axis=0).max() < 1e-6


def test_its_folder_of_obj_files_is_the_same_face(tmp_path, arrays, face):
    def write(name, vertices, polygons=()):
        rows = ["v " + " ".join(map(repr, row)) for row in vertices.tolist()]
        rows += ["f " + " ".join(f"{v}/{v}" for v in row) for row in polygons]
        (tmp_path / name).write_text("\n".join(rows))

    neutral = arrays["neutral"]
    write(ict.NEUTRAL, neutral, (arrays["quads"] + 1).tolist())
    for name in ("jawOpen", "eyeBlink_L"):
        write(f"{name}.obj", neutral + arrays["expr_delta"][list(arrays["expr_names"]).index(name)])
    write("identity000.obj", neutral)
    found = load_face(tmp_path)
    assert found.shape_names == ("eyeBlinkLeft", "jawOpen")
    assert found.identity_names == ("identity000",)
    for name in found.shape_names:
        np.testing.assert_allclose(offsets(found, name), offsets(face, name), atol=1e-6)
    for name in ("neutral", "skin", "colours", "landmarks"):
        np.testing.assert_allclose(getattr(found, name), getattr(face, name), atol=1e-6)


def test_random_numbers_in_its_layout_are_read(tmp_path, like_ict):
    np.savez(tmp_path / "face.npz", **like_ict)
    face = load_face(tmp_path / "face.npz")
    assert face.shape_names == ("jawOpen",) and face.identity_names == ("identity000",)
    np.testing.assert_allclose(face.neutral, like_ict["neutral"] / 100, rtol=1e-5)
    assert set(face.gloss[ict.BALLS["left_eye"]]) == {1.0} and face.gloss[0] < 1


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"quads": None}, "found no array quads"),
        (
            {"neutral": np.zeros((26718, 3))},
            "array neutral: found shape (26718, 3), expected (26719",
        ),
        ({"neutral": np.zeros((ict.N_VERTICES, 3))}, "expected a head of 0.12-0.8 m"),
        ({"quads": np.full((2, 4), ict.N_VERTICES)}, "array quads: found numbers from 26719"),
        ({"quads": np.full((2, 4), -1)}, "array quads: found numbers from -1"),
        ({"expr_names": np.array([b"jawOpen"])}, "array expr_names: found type |S7, expected text"),
        ({"expr_names": np.array([1])}, "array expr_names: found type int64, expected text"),
        ({"expr_names": np.array([["jawOpen"]])}, "array expr_names: found shape (1, 1)"),
        (
            {"expr_names": np.array(["jawOpen", "a"])},
            "array expr_names: found shape (2,), expected",
        ),
        ({"expr_names": np.array(["mine"])}, "found shapes mine"),
        ({"ident_names": np.array([7])}, "array ident_names: found type int64, expected text"),
        (
            {"ident_delta_face": np.zeros((1, 9, 3))},
            "array ident_delta_face: found shape (1, 9, 3)",
        ),
    ],
)
def test_what_is_not_ict_is_refused(tmp_path, like_ict, change, message):
    arrays = {name: value for name, value in (like_ict | change).items() if value is not None}
    np.savez(tmp_path / "face.npz", **arrays)
    with pytest.raises(BadFile) as caught:
        load_face(tmp_path / "face.npz")
    assert message in str(caught.value)


def test_it_is_read_in_centimetres_only(tmp_path, like_ict):
    np.savez(tmp_path / "face.npz", **like_ict | {"neutral": like_ict["neutral"] / 100})
    with pytest.raises(BadFile, match="expected a head in centimetres"):
        load_face(tmp_path / "face.npz")


@pytest.mark.parametrize("text", ["v 0 0 0\nv 0 30 0\nv 1 0 0\nf 1 2 3\n"])
def test_a_folder_of_another_mesh_is_refused(tmp_path, text):
    (tmp_path / ict.NEUTRAL).write_text(text)
    with pytest.raises(BadFile, match="found 3 vertices, expected 26719"):
        load_face(tmp_path)
