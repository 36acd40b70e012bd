"""The embedded face at rest: its mesh, its landmarks, its persons and its joints."""

from dataclasses import replace

import numpy as np
import pytest

from mimeline.face.embedded import embedded_face
from mimeline.face.embedded import mesh as embedded_mesh
from mimeline.face.embedded.identities import NAMES
from mimeline.face.embedded.sculpture import CENTRE
from mimeline.face.embedded.skin import BORDER
from mimeline.face.render import Camera, draw
from mimeline.face.rotations import turned
from mimeline.vocabulary import EXPRESSIONS

LOOKS = [name for name in EXPRESSIONS if name.startswith("eyeLook")]


@pytest.fixture(scope="module")
def face():
    return embedded_face()


@pytest.fixture(scope="module")
def mesh():
    return embedded_mesh.build()


@pytest.fixture(scope="module")
def partner(face):
    """The vertex of the mirror image of each vertex's exact position."""
    where = {tuple(point): number for number, point in enumerate(face.neutral)}
    return np.array([where[tuple(point)] for point in face.neutral * np.float32([-1, 1, 1])])


def persons() -> list[dict[str, float]]:
    """Each identity alone at its ends, and mixtures."""
    ends = [{name: end} for name in NAMES for end in (-1.0, 1.0)]
    mixtures = np.random.default_rng(5).choice([-0.7, 0.7], (8, len(NAMES)))
    return [{}, *ends, *(dict(zip(NAMES, mixture, strict=True)) for mixture in mixtures)]


def normals(points, triangles):
    a, b, c = points[triangles].transpose(1, 0, 2)
    return np.cross(b - a, c - a)


def test_it_brings_all_52_channels_and_some_persons(face):
    assert face.shape_names == EXPRESSIONS
    assert face.identity_names == NAMES
    assert 1500 < len(face.neutral) < 3500


def test_it_is_symmetric_to_the_last_bit(face, partner):
    assert (partner[partner] == np.arange(len(partner))).all()
    assert (face.colours[partner] == face.colours).all()
    for identity in face.identities:
        assert np.array_equal(identity[partner], identity * np.float32([-1, 1, 1]))


def test_its_triangles_are_mirrored_too(face, partner):
    def kinds(triangles):
        first = triangles.argmin(1)[:, None]
        return {tuple(t) for t in np.take_along_axis(triangles, (first + np.arange(3)) % 3, 1)}

    assert kinds(face.triangles) == kinds(partner[face.triangles][:, ::-1])


def test_every_vertex_belongs_to_a_triangle_with_an_area(face):
    assert np.array_equal(np.unique(face.triangles), np.arange(len(face.neutral)))
    area = np.linalg.norm(normals(face.neutral, face.triangles), axis=1) / 2
    assert area.min() > 1e-9  # square metres


def test_neighbouring_triangles_turn_the_same_way(face):
    edges = np.concatenate([face.triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
    assert len(np.unique(edges, axis=0)) == len(edges)


def test_the_skin_is_closed_but_for_eyes_and_neck(face, mesh):
    on_skin = face.triangles[(mesh.part[face.triangles] == "skin").all(1)]
    edges = np.concatenate([on_skin[:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
    edges, uses = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    rim = np.unique(edges[uses == 1])
    rim_of_lids = np.isin(rim, np.r_[mesh.skin.lids[0], mesh.partner[mesh.skin.lids[0]]])
    neck = face.neutral[rim, 1] < face.neutral[:, 1].min() + 1e-4
    assert (rim_of_lids | neck).all()


def test_triangles_of_skin_and_eyes_face_outwards(mesh):
    inside = np.zeros(len(mesh.points), bool)
    hidden = np.r_[mesh.skin.lips[: BORDER + 2].ravel(), mesh.skin.lids[:3].ravel()]
    inside[hidden] = inside[mesh.partner[hidden]] = True
    out = normals(mesh.points, mesh.triangles)
    middle = mesh.points[mesh.triangles].mean(1)
    skin = ((mesh.part == "skin") & ~inside)[mesh.triangles].all(1)
    hair = (mesh.materials == "hair")[mesh.triangles]
    skin &= hair.all(1) | ~hair.any(1)  # the edge of the hair hangs over
    assert ((out * (middle - CENTRE)).sum(1)[skin] > 0).all()
    left = mesh.points[mesh.left("eye")]
    ball = (left.min(0) + left.max(0)) / 2
    eye = (mesh.part == "eye")[mesh.triangles].all(1)
    from_ball = middle - ball * np.sign(middle[:, :1]) * [1, 0, 0] - ball * [0, 1, 1]
    assert ((out * from_ball).sum(1)[eye] > 0).all()


def test_landmarks_mirror_each_other(face, partner):
    mirror = [*range(16, -1, -1), *range(26, 16, -1), 27, 28, 29, 30, 35, 34, 33, 32, 31]
    mirror += [45, 44, 43, 42, 47, 46, 39, 38, 37, 36, 41, 40]
    mirror += [54, 53, 52, 51, 50, 49, 48, 59, 58, 57, 56, 55, 64, 63, 62, 61, 60, 67, 66, 65]
    assert np.array_equal(partner[face.landmarks], face.landmarks[mirror])


def test_landmarks_lie_where_their_names_say(face):
    x, y, z = face.landmarks_at(face.neutral[None])[0].T
    assert len(set(face.landmarks)) == 68
    assert (np.diff(x[:17]) > 0).all()  # the jaw, from the subject's right to the left
    assert y[:17].argmin() == 8
    assert (np.diff(x[17:27]) > 0).all()
    assert (np.diff(y[27:31]) < 0).all()  # down the bridge
    assert z.argmax() == 30  # the tip of the nose
    assert (np.diff(x[31:36]) > 0).all()
    for outer, inner, upper, lower in ((36, 39, (37, 38), (41, 40)), (45, 42, (44, 43), (46, 47))):
        assert abs(x[outer]) > abs(x[inner])
        assert (y[list(upper)] > y[list(lower)] + 0.005).all()
    assert (y[17:27] > y[36:48].max()).all()
    assert (np.diff(x[48:55]) > 0).all()
    assert (np.diff(x[54:60]) < 0).all()
    assert (y[[49, 50, 51, 52, 53]] > y[[59, 58, 57, 56, 55]]).all()
    assert (np.diff(x[60:65]) > 0).all()
    assert (y[[61, 62, 63]] >= y[[67, 66, 65]]).all()
    assert y[33] > y[51] > y[62] > y[57] > y[8]


@pytest.mark.parametrize("person", persons(), ids=lambda p: "-".join(map(str, list(p)[:2])))
def test_no_person_tears_the_mesh(face, person):
    edges = np.concatenate([face.triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
    lengths = [
        np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
        for points in (face.neutral, face.of(person).neutral)
    ]
    stretch = (lengths[1] / lengths[0])[lengths[0] > 1e-3]
    assert stretch.min() > 0.4
    assert stretch.max() < 2


def eyeballs_seen(face, person, coefficients) -> int:
    """Pixels of the eyeballs in a picture in which nothing else is green."""
    is_ball = face.skin[:, -2:].sum(1) > 0.5
    marked = replace(face, colours=np.uint8([[0, 255, 0] if ball else [0] * 3 for ball in is_ball]))
    one = marked.of(person)
    values = np.array([[coefficients.get(name, 0) for name in one.shape_names]])
    picture = draw(one, one.vertices(values)[0], Camera.framing(one, 256), (0, 0, 0)).astype(int)
    return int((picture[..., 1] - picture[..., 0] > 40).sum())


BLINK = {"eyeBlinkLeft": 1.0, "eyeBlinkRight": 1.0}


@pytest.mark.parametrize("person", persons(), ids=lambda p: "-".join(map(str, list(p)[:2])))
def test_a_blink_covers_the_ball_of_every_person(face, person):
    assert eyeballs_seen(face, person, {}) > 150
    assert eyeballs_seen(face, person, BLINK) == 0


@pytest.mark.parametrize("stem", ["eyeSquint", "cheekSquint", "mouthSmile", "eyeLookDown"])
def test_a_blink_still_covers_the_ball_amid_other_expressions(face, stem):
    assert eyeballs_seen(face, {}, BLINK | {f"{stem}Left": 1.0, f"{stem}Right": 1.0}) == 0


def test_looking_moves_lids_and_leaves_the_balls_to_their_joints(face):
    is_ball = face.skin[:, -2:].sum(1) > 0.5
    for name in LOOKS:
        shape = face.shapes[face.shape_names.index(name)]
        assert np.abs(shape[~is_ball]).max() > 3e-4
        assert not shape[is_ball].any()


def test_the_eyes_turn_about_their_own_centres(face):
    look = turned(np.array([0.4]), np.array([0.0]), np.array([0.0]))
    rest = np.zeros((1, len(EXPRESSIONS)))
    posed = face.vertices(rest, {"left_eye": look, "right_eye": look})[0]
    for side, joint in ((-2, face.joints[-2]), (-1, face.joints[-1])):
        ball = face.skin[:, side] > 0.5
        before, after = face.neutral[ball] - joint.centre, posed[ball] - joint.centre
        assert np.ptp(np.linalg.norm(before, axis=1)) < 1e-5
        assert np.allclose(np.linalg.norm(after, axis=1), np.linalg.norm(before, axis=1), atol=1e-5)
        assert after[before[:, 2].argmax(), 0] > 0.005  # the pupil goes to the subject's left
    still = face.skin[:, -2:].sum(1) == 0
    assert np.allclose(posed[still], face.neutral[still], atol=1e-6)


def test_the_neck_stays_where_it_is_cut_when_the_head_turns(face):
    turn = turned(np.array([0.5]), np.array([0.2]), np.array([0.1]))
    posed = face.vertices(np.zeros((1, len(EXPRESSIONS))), {"head": turn})[0]
    foot = face.neutral[:, 1] < face.neutral[:, 1].min() + 1e-4
    assert np.allclose(posed[foot], face.neutral[foot], atol=1e-6)
    assert np.linalg.norm(posed - face.neutral, axis=1)[face.landmarks].min() > 0.01


def test_colours_follow_what_is_asked_for():
    face, dark = embedded_face(), embedded_face(skin=(90, 60, 45), hair=(20, 16, 14))
    assert embedded_face() is face
    assert (dark.colours != face.colours).any(1).mean() > 0.5
    assert np.array_equal(dark.neutral, face.neutral)
    chin = face.landmarks[8]
    assert tuple(dark.colours[chin]) == (90, 60, 45)
