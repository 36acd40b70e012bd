"""BFM_model_front.mat's layout with the embedded face in it: no Basel Face Model is here."""

import numpy as np
import pytest
from scipy.io import savemat

from mimeline.errors import BadFile
from mimeline.face.embedded import embedded_face
from mimeline.face.load import load_face


def published(**change) -> dict[str, np.ndarray]:
    """The file's arrays, in decimetres and off the origin; None takes one away."""
    face = embedded_face()
    V, rng = len(face.neutral), np.random.default_rng(0)
    arrays = {
        "meanshape": (10 * face.neutral + [0.1, 0.2, 0.3]).reshape(1, -1),
        "idBase": rng.normal(0, 0.01, (3 * V, 80)).astype(np.float32),
        "exBase": rng.normal(0, 0.01, (3 * V, 64)),
        "meantex": np.float32(face.colours).reshape(1, -1),
        "tri": face.triangles + 1.0,
        "keypoints": face.landmarks[None] + 1.0,
    }
    return {name: value for name, value in (arrays | change).items() if value is not None}


def saved(path, **change):
    savemat(path, published(**change), do_compression=True)
    return path


@pytest.fixture(scope="module")
def face(tmp_path_factory):
    return load_face(saved(tmp_path_factory.mktemp("bfm") / "BFM_model_front.mat"))


def test_it_has_64_expressions_80_identities_and_68_landmarks(face):
    assert len(face.shape_names) == 64 and face.shape_names[63] == "exp063"
    assert len(face.identity_names) == 80 and face.identity_names[0] == "shape000"
    np.testing.assert_array_equal(face.landmarks, embedded_face().landmarks)


def test_decimetres_become_metres_about_the_mean(face):
    known = embedded_face().neutral
    np.testing.assert_allclose(face.neutral, known - known.mean(0), atol=1e-6)
    offsets = published()["exBase"][:, 5].reshape(-1, 3)
    np.testing.assert_allclose(face.shapes[5], 0.1 * offsets, rtol=1e-4, atol=1e-9)


def test_vertices_are_counted_from_1_and_keep_their_colours(face):
    np.testing.assert_array_equal(face.triangles, embedded_face().triangles)
    np.testing.assert_array_equal(face.colours, embedded_face().colours)


def test_triangles_that_face_inwards_are_turned(tmp_path):
    inwards = embedded_face().triangles[:, ::-1] + 1.0
    front = embedded_face().neutral[embedded_face().triangles].mean(1)[:, 2] > 0.05
    face = load_face(saved(tmp_path / "bfm.mat", tri=inwards[front]))
    np.testing.assert_array_equal(face.triangles, embedded_face().triangles[front])


def test_a_file_without_colours_is_a_face_too(tmp_path):
    face = load_face(saved(tmp_path / "bfm.mat", meantex=None))
    assert len(np.unique(face.colours, axis=0)) == 1


@pytest.mark.parametrize(
    "change",
    [
        {"exBase": None},
        {"meanshape": np.zeros((1, 300))},
        {"meanshape": np.zeros((0, 0))},
        {"exBase": np.zeros((30, 64))},
        {"tri": np.array([[0.0, 1, 2]])},  # counted from 0
        {"keypoints": np.arange(1.0, 60)[None]},
        {"meanshape": np.full((1, 3 * len(embedded_face().neutral)), np.nan)},
        {"meantex": np.zeros((1, 7))},
    ],
    ids=[
        "no expressions",
        "flat",
        "empty",
        "other length",
        "from 0",
        "59 points",
        "NaN",
        "colours",
    ],
)
def test_what_is_not_whole_is_refused(tmp_path, change):
    with pytest.raises(BadFile):
        load_face(saved(tmp_path / "bfm.mat", **change))


@pytest.mark.parametrize("axes", [[-1, 1, 1], [1, -1, 1], [1, 1, -1]])
def test_a_turned_or_mirrored_face_is_refused(tmp_path, axes):
    mean = (10 * embedded_face().neutral * axes).reshape(1, -1)
    with pytest.raises(BadFile, match="turned or mirrored"):
        load_face(saved(tmp_path / "bfm.mat", meanshape=mean))
