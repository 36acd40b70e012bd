import numpy as np
import pytest

from mimeline.face.fitting import Unfit
from mimeline.face.model import SKIN_GLOSS, Joint

from .conftest import chained_face, rotations


def by_loops(face, coefficients, turns):
    """Vertices (V, 3) of one frame, written out. turns: a rotation per joint."""
    posed = face.neutral.astype(float)
    for weight, shape in zip(coefficients, face.shapes, strict=True):
        posed = posed + weight * shape
    centres = [joint.centre for joint in face.joints]
    if face.regressor is not None:
        centres = face.regressor @ posed
    if face.pose_shapes is not None:
        feature = np.concatenate([(turn - np.eye(3)).ravel() for turn in turns[1:]])
        for weight, shape in zip(feature, face.pose_shapes, strict=True):
            posed = posed + weight * shape
    placed = []
    for joint, turn, centre in zip(face.joints, turns, centres, strict=True):
        own = np.eye(4)
        own[:3, :3], own[:3, 3] = turn, centre - turn @ centre
        placed.append(own if joint.parent is None else placed[joint.parent] @ own)
    out = np.zeros_like(posed)
    for v, point in enumerate(posed):
        for weight, matrix in zip(face.skin[v], placed, strict=True):
            out[v] += weight * (matrix[:3, :3] @ point + matrix[:3, 3])
    return out


def regressed(seed=0):
    """As FLAME: joint centres that follow the vertices, and shapes that correct a pose."""
    rng = np.random.default_rng(seed)
    regressor, neutral = rng.dirichlet(np.ones(12), 3), rng.normal(size=(12, 3))
    rows = zip(("head", "neck", "jaw"), (None, 0, 1), regressor @ neutral, strict=True)
    joints = [Joint(*row) for row in rows]
    pose_shapes = rng.normal(size=(18, 12, 3))
    return chained_face(
        seed, neutral=neutral, joints=joints, pose_shapes=pose_shapes, regressor=regressor
    )


@pytest.mark.parametrize("make", [chained_face, regressed])
def test_vertices_are_those_of_plain_loops(make):
    face, rng = make(), np.random.default_rng(1)
    coefficients, turns = rng.normal(size=(4, 2)), rotations(rng, 12).reshape(3, 4, 3, 3)
    found = face.vertices(coefficients, dict(zip(face.joint_names, turns, strict=True)))
    expected = [by_loops(face, coefficients[n], turns[:, n]) for n in range(4)]
    assert found.dtype == np.float32
    np.testing.assert_allclose(found, expected, atol=2e-5)


def test_a_joint_that_is_not_turned_rests_and_follows_its_parent():
    face, rng = chained_face(), np.random.default_rng(2)
    turn, rest = rotations(rng, 3), np.tile(np.eye(3), (3, 1, 1))
    some = face.vertices(np.zeros((3, 2)), {"head": turn})
    every = face.vertices(np.zeros((3, 2)), {"head": turn, "neck": rest, "left_eye": rest})
    np.testing.assert_allclose(some, every, atol=1e-6)


def test_an_identity_changes_the_neutral_face_and_what_a_shape_does():
    face = chained_face()
    person = face.of({"wide": 0.5, "long": -1})
    neutral = face.neutral + 0.5 * face.identities[0] - face.identities[1]
    shapes = face.shapes + 0.5 * face.correctives[0] - face.correctives[1]
    np.testing.assert_allclose(person.neutral, neutral, atol=1e-6)
    np.testing.assert_allclose(person.shapes, shapes, atol=1e-6)
    assert person.identity_names == () and person.correctives is None


def test_a_joint_moves_with_the_vertices_that_it_holds():
    face = chained_face(skin=np.repeat(np.eye(3), 4, axis=0))
    moved = face.of({"wide": 1})
    for number in range(3):
        held = slice(4 * number, 4 * number + 4)
        by = face.identities[0, held].mean(0)
        found = moved.joints[number].centre - face.joints[number].centre
        np.testing.assert_allclose(found, by, atol=1e-5)


def test_no_identity_leaves_the_face_as_it_is():
    face = chained_face()
    np.testing.assert_array_equal(face.of({}).shapes, face.shapes)


def test_unknown_names_are_refused_with_the_known_ones():
    face = chained_face()
    with pytest.raises(ValueError, match="no identity thin; this face has wide, long"):
        face.of({"thin": 1})
    with pytest.raises(ValueError, match="no joint jaw; this face has neck, head, left_eye"):
        face.vertices(np.zeros((1, 2)), {"jaw": np.eye(3)[None]})


@pytest.mark.parametrize(
    ("coefficients", "turns", "message"),
    [
        (np.zeros(2), None, r"coefficients have shape \(2,\), expected \(frames, 2\)"),
        (np.zeros((4, 3)), None, r"expected \(frames, 2\)"),
        (np.zeros((4, 2)), {"head": np.eye(3)}, r"rotations of head .*expected \(4, 3, 3\)"),
    ],
)
def test_arrays_of_another_shape_are_refused(coefficients, turns, message):
    with pytest.raises(ValueError, match=message):
        chained_face().vertices(coefficients, turns)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (
            {"shapes": np.zeros((2, 11, 3))},
            r"shapes: found shape \(2, 11, 3\), expected \(2, 12, 3\)",
        ),
        (
            {"shapes": np.full((2, 12, 3), 1e39)},
            "shapes: found numbers from 1e.39 to 1e.39, expected -1e.06",
        ),
        ({"shape_names": ["jawOpen", "jawOpen"]}, "shape names: found jawOpen twice"),
        ({"triangles": [[0, 1, 12]]}, "triangles: found numbers from 0 to 12, .* 0-11"),
        ({"triangles": [[0.0, 1.0, 1.5]]}, "triangles: found fractions"),
        ({"triangles": [[0, 1, np.nan]]}, "triangles: found numbers that are not finite"),
        ({"landmarks": np.arange(68)}, "landmarks: found numbers from 0 to 67, .* 0-11"),
        ({"skin": np.ones((12, 3))}, "do not sum to 1"),
        ({"neutral": np.full((12, 3), np.nan)}, "neutral: found numbers that are not finite"),
        ({"neutral": np.zeros((0, 3))}, "neutral: found no vertices"),
        ({"colours": np.full((12, 3), np.nan)}, "colours: found numbers that are not finite"),
        ({"colours": np.full((12, 3), 2**62)}, "colours: found numbers from .* expected 0 to 255"),
        ({"colours": np.full((12, 3), 0.5)}, "colours: found fractions"),
        ({"gloss": np.ones(11)}, r"gloss: found shape \(11,\), expected \(12,\)"),
        ({"gloss": np.full(12, 1.5)}, "gloss: found numbers from 1.5 to 1.5, expected 0 dull to 1"),
        ({"correctives": np.zeros((1, 2, 12, 3))}, "correctives: found shape"),
        (
            {"joints": [Joint(n, 2, np.zeros(3)) for n in "abc"]},
            "joint a: found parent 2 of joint 0",
        ),
        (
            {"joints": [Joint(n, None, [0, 0, np.nan]) for n in "abc"]},
            "joint a: found numbers that",
        ),
        ({"joints": [Joint(n, None, np.zeros(2)) for n in "abc"]}, "joint a: found shape"),
    ],
)
def test_a_face_whose_parts_do_not_fit_is_refused(wrong, message):
    with pytest.raises(Unfit, match=message):
        chained_face(**wrong)


def test_landmarks_are_vertices_of_every_frame():
    face = chained_face(landmarks=np.arange(68) % 12)
    vertices = np.random.default_rng(0).normal(size=(5, 12, 3))
    np.testing.assert_array_equal(face.landmarks_at(vertices)[:, 13], vertices[:, 1])
    with pytest.raises(ValueError, match="names no landmarks"):
        chained_face().landmarks_at(vertices)


def test_vertices_without_a_gloss_are_as_dry_skin(ball_face):
    assert (ball_face.gloss == np.float32(SKIN_GLOSS)).all()


def test_a_person_shines_as_the_model_does():
    gloss = np.linspace(0, 1, 12, dtype=np.float32)
    np.testing.assert_array_equal(chained_face(gloss=gloss).of({"wide": 1}).gloss, gloss)
