from dataclasses import replace

import numpy as np
import pytest

from mimeline.face.load import load_face
from mimeline.face.model import Face, Joint
from mimeline.face.motion import driver
from mimeline.face.retarget import LEAST_QUALITY, retargeting
from mimeline.face.rotations import turned
from mimeline.vocabulary import EXPRESSIONS

from .conftest import chained_face

NAMES = [name for name in EXPRESSIONS if not name.startswith("eyeLook")]


@pytest.fixture(scope="module")
def face() -> Face:
    return replace(load_face(None), correctives=None, identities=None, identity_names=())


@pytest.fixture(scope="module")
def ict(real_data) -> Face:
    return load_face(real_data / "face" / "ict_facekit_compact.npz")


@pytest.fixture(scope="module")
def from_ict(ict, face):
    return retargeting(ict, face, NAMES)


def without(face: Face, *names: str) -> Face:
    kept = [name for name in face.shape_names if name not in names]
    shapes = face.shapes[[face.shape_names.index(name) for name in kept]]
    return replace(face, shapes=shapes, shape_names=kept)


def divided(face: Face) -> Face:
    """The same surface of four times as many triangles, turned, smaller and elsewhere."""
    edges = np.concatenate([face.triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
    edges, middle = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True)
    V = len(face.neutral)
    ab, bc, ca = V + middle.reshape(3, -1)
    a, b, c = face.triangles.T
    corners = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    turn = 0.9 * turned(np.zeros(1), np.full(1, 0.1), np.zeros(1))[0]

    def more(values):
        return np.concatenate([values, values[edges].mean(1)])

    return Face(
        neutral=more(face.neutral) @ turn.T + [0, 0.02, -0.01],
        triangles=np.concatenate([np.stack(corner, axis=1) for corner in corners]),
        shapes=np.array([more(shape) for shape in face.shapes]) @ turn.T,
        shape_names=face.shape_names,
        joints=[replace(j, centre=turn @ j.centre + [0, 0.02, -0.01]) for j in face.joints],
        skin=more(face.skin),
        landmarks=face.landmarks,
    )


def sparse(n: int, S: int, seed: int = 0) -> np.ndarray:
    """Expressions (n, S) of few shapes each."""
    rng = np.random.default_rng(seed)
    return rng.uniform(0.2, 1, (n, S)) * (rng.random((n, S)) < 3 / S)


def test_a_face_is_mapped_to_itself_exactly(face):
    way = retargeting(without(face, *set(face.shape_names) - set(NAMES)), face, NAMES)
    assert way.names == tuple(NAMES) and way.possible.all()
    assert way.quality.min() > 0.999
    one_at_a_time = 0.7 * np.eye(len(NAMES))
    np.testing.assert_allclose(way.coefficients(one_at_a_time), one_at_a_time, atol=1e-4)


def test_a_shape_that_the_source_cannot_show_is_not_possible_and_the_others_are(face):
    way = retargeting(without(face, "cheekPuff", "tongueOut"), face, NAMES)
    possible = dict(zip(NAMES, way.possible, strict=True))
    assert [name for name in NAMES if not possible[name]] == ["cheekPuff", "tongueOut"]
    assert way.quality[way.possible].min() > 0.95
    assert way.quality[~way.possible].max() < LEAST_QUALITY
    found = way.coefficients(np.zeros((2, len(face.shape_names) - 2)))
    assert np.isnan(found[:, ~way.possible]).all() and not found[:, way.possible].any()


def test_what_the_source_shows_only_beyond_any_trackers_coefficients_is_not_possible(face):
    weak = replace(face, shapes=face.shapes / 1000)
    assert not retargeting(weak, face, NAMES).possible.any()
    number = face.shape_names.index("cheekPuff")
    for share, possible in ((0.5, True), (0.01, False), (1e-3, False)):
        shapes = face.shapes.copy()
        shapes[number] *= share  # a 1 is had by a coefficient of 2, 100, 1000
        way = retargeting(replace(face, shapes=shapes), face, NAMES)
        assert way.possible[NAMES.index("cheekPuff")] == possible
        assert way.possible.sum() == len(NAMES) - (not possible)


def test_shapes_that_together_ask_for_more_than_a_tracker_gives_have_less_quality(face):
    """Each alone is had with a coefficient of 2.5, both together with 5."""
    names = ["browInnerUp", "cheekPuff"]
    brow, cheek = face.shapes[[face.shape_names.index(name) for name in names]]
    source = replace(face, shapes=np.array([brow, cheek]), shape_names=names)
    for both, least, most in ((0.5, 0.999, 1), (2.5, 0, 0.98)):
        shapes = np.array([both * brow + cheek, both * brow - cheek])
        way = retargeting(source, replace(face, shapes=shapes, shape_names=names), names)
        assert way.solved.all() and least < way.quality.min() <= way.quality.max() <= most


def test_a_shape_that_moves_mostly_what_the_source_has_no_surface_for_is_not_possible(face):
    """Though the source shows all of it that lies on the skin."""
    tongue = face.shapes[face.shape_names.index("tongueOut")]
    at_the_lips = 0.02 * face.shapes[face.shape_names.index("mouthFunnel")]
    shapes, names = np.array([at_the_lips, tongue + at_the_lips]), ["mouthFunnel", "tongueOut"]
    source = divided(replace(face, shapes=shapes[:1], shape_names=names[:1]))
    way = retargeting(source, replace(face, shapes=shapes, shape_names=names), names)
    assert way.quality[1] == 0 and way.possible.tolist() == [True, False]
    assert way.coefficients(np.ones((1, 1)))[0] == pytest.approx([1, np.nan], abs=0.05, nan_ok=True)


def test_shapes_that_cannot_be_told_apart_are_not_possible_but_take_their_share(face):
    """Of six that are alike each gets a sixth: none is told, and none goes to another."""
    alike = ["mouthFunnel", "mouthPucker", "mouthClose", "mouthShrugUpper"]
    alike += ["mouthRollUpper", "mouthRollLower"]
    shapes, names = list(face.shapes), list(face.shape_names)
    for name in alike:
        shapes[names.index(name)] = shapes[names.index("mouthFunnel")]
    source = without(face, *alike[1:])
    way = retargeting(source, replace(face, shapes=np.array(shapes)), NAMES)
    places = [NAMES.index(name) for name in alike]
    assert way.solved.all() and np.flatnonzero(~way.possible).tolist() == sorted(places)
    funnel = np.eye(len(source.shape_names))[[source.shape_names.index("mouthFunnel")]]
    found = way.coefficients(funnel)[0]
    assert np.isnan(found[places]).all()
    np.testing.assert_allclose(np.delete(found, places), 0, atol=1e-3)


def test_shapes_that_undo_each_other_cost_each_other_no_quality(face):
    shapes, names = face.shapes.copy(), list(face.shape_names)
    shapes[names.index("jawRight")] = -shapes[names.index("jawLeft")]
    few = ["jawLeft", "jawRight", "browInnerUp", "cheekPuff", "eyeBlinkLeft", "eyeBlinkRight"]
    other = replace(face, shapes=shapes)
    assert retargeting(other, other, few).quality.min() > 0.99


def test_a_side_that_the_source_cannot_show_costs_the_other_nothing(face):
    way = retargeting(without(face, "noseSneerLeft"), face, NAMES)
    quality = dict(zip(NAMES, way.quality, strict=True))
    assert quality["noseSneerLeft"] < LEAST_QUALITY
    assert quality["noseSneerRight"] > 0.95


@pytest.mark.parametrize(("marked", "apart"), [(True, 0.002), (False, 0.03)])
def test_another_topology_turned_smaller_and_elsewhere_changes_little(face, marked, apart):
    source = divided(face) if marked else replace(divided(face), landmarks=None)
    way = retargeting(source, face, NAMES)
    possible = [name for name, is_it in zip(NAMES, way.possible, strict=True) if is_it]
    assert set(NAMES) - set(possible) <= {"tongueOut"}
    sent = sparse(200, len(face.shape_names))
    for number, name in enumerate(face.shape_names):
        if name not in possible or name.endswith("Right"):  # jawRight undoes jawLeft
            sent[:, number] = 0
    wanted = sent[:, [face.shape_names.index(name) for name in possible]]
    error = way.coefficients(sent)[:, way.possible] - wanted
    assert np.sqrt((error**2).mean()) < apart


def test_rows_without_numbers_stay_without(face):
    way = retargeting(face, face, ["jawOpen", "mouthFunnel"])
    source = np.zeros((3, len(face.shape_names)))
    source[0, face.shape_names.index("jawOpen")] = 0.5
    source[1, 3] = np.nan
    found = way.coefficients(source)
    assert np.isnan(found).all(1).tolist() == [False, True, False]
    assert found[0] == pytest.approx([0.5, 0], abs=1e-3)


def test_no_coefficient_leaves_its_bounds(from_ict, ict):
    wild = np.random.default_rng(1).normal(0, 2, (200, len(ict.shape_names)))
    for most in (1.0, 1.05):
        found = from_ict.coefficients(wild, most)[:, from_ict.possible]
        assert found.min() == 0 and found.max() == most


def test_the_same_faces_give_the_same_way(face):
    first, second = (retargeting(face, face, NAMES) for _ in range(2))
    assert np.array_equal(first.quality, second.quality)
    assert np.array_equal(first.cross, second.cross)


def test_what_has_neither_eyes_nor_landmarks_is_refused(face):
    with pytest.raises(ValueError, match="landmarks"):
        retargeting(chained_face(), face)


def test_what_has_hardly_a_surface_is_refused(face):
    eyes = [replace(j, parent=None) for j in face.joints if j.name.endswith("eye")]
    scrap = Face(
        neutral=face.neutral[:3],
        triangles=[[0, 1, 2]],
        shapes=np.zeros((1, 3, 3)),
        shape_names=["exp000"],
        joints=[Joint("head", None, np.zeros(3)), *eyes],
        skin=np.eye(3)[[0, 0, 0]],
    )
    with pytest.raises(ValueError, match="surfaces|points"):
        retargeting(scrap, face)


@pytest.mark.parametrize("marked", [True, False])
def test_icts_channels_are_found_again_on_the_embedded_face(ict, face, from_ict, marked):
    way = from_ict if marked else retargeting(replace(ict, landmarks=None), face, NAMES)
    sent = sparse(1000, len(NAMES))
    drives = np.array([[driver(shape) == name for shape in ict.shape_names] for name in NAMES])
    back = way.coefficients(sent @ drives)
    found = {
        name: np.corrcoef(sent[:, number], back[:, number])[0, 1]
        for number, name in enumerate(NAMES)
        if way.possible[number]
    }
    for name in (
        "browInnerUp",
        "browOuterUpLeft",
        "browDownRight",
        "eyeBlinkLeft",
        "jawOpen",
        "mouthClose",
    ):
        assert found[name] > 0.8, name
    for name in ("eyeWideRight", "mouthSmileLeft", "mouthStretchRight", "eyeSquintLeft"):
        assert found[name] > 0.6, name
    assert "tongueOut" not in found  # ICT has none


def test_ict_moves_the_side_that_it_names(ict, from_ict):
    for name in ("mouthSmileLeft", "browDownLeft", "eyeBlinkLeft", "mouthStretchLeft"):
        one = (np.array(ict.shape_names) == name).astype(float)[None]
        left, right = (
            from_ict.coefficients(one)[0, NAMES.index(side)]
            for side in (name, name.replace("Left", "Right"))
        )
        assert left > 0.25 and right < 0.3 * left, name
