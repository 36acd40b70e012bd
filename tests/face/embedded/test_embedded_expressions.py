"""What each of the 52 channels does to the embedded face."""

import numpy as np
import pytest

from mimeline.face.embedded import embedded_face
from mimeline.vocabulary import CHANNELS, EXPRESSIONS

X, Y, Z = np.eye(3)

# channel → landmark that it moves, and where to. Right-hand channels are told by their mirror.
MOVES = {
    "eyeBlinkLeft": (43, -Y),
    "eyeLookDownLeft": (43, -Y),
    "eyeLookInLeft": (43, -X),
    "eyeLookOutLeft": (43, X),
    "eyeLookUpLeft": (43, Y),
    "eyeSquintLeft": (47, Y),
    "eyeWideLeft": (43, Y),
    "jawForward": (8, Z),
    "jawLeft": (8, X),
    "jawOpen": (8, -Y),
    "mouthClose": (66, Y),
    "mouthFunnel": (51, Z),
    "mouthPucker": (54, -X),
    "mouthLeft": (57, X),
    "mouthSmileLeft": (54, Y),
    "mouthFrownLeft": (54, -Y),
    "mouthDimpleLeft": (54, -Z),
    "mouthStretchLeft": (54, X),
    "mouthRollLower": (57, Y),
    "mouthRollUpper": (51, -Y),
    "mouthShrugLower": (57, Y),
    "mouthShrugUpper": (51, Y),
    "mouthPressLeft": (56, Y),
    "mouthLowerDownLeft": (56, -Y),
    "mouthUpperUpLeft": (52, Y),
    "browDownLeft": (23, -Y),
    "browInnerUp": (22, Y),
    "browOuterUpLeft": (25, Y),
    "cheekPuff": (13, X),
    "cheekSquintLeft": (46, Y),
    "noseSneerLeft": (35, Y),
    "tongueOut": (66, -Y),
}

EYE, BROW, NOSE, MOUTH, JAW = (
    range(42, 48),
    range(22, 27),
    range(31, 36),
    range(48, 60),
    [*range(3, 14), *range(48, 60)],
)
# start of a channel's name → landmarks and how far from them, in centimetres, it may move anything
REACHES = {
    "eye": (EYE, 2.5),
    "brow": (BROW, 3.0),
    "cheekPuff": (JAW, 7.0),
    "cheekSquint": ([*EYE, *NOSE], 4.0),
    "noseSneer": ([*BROW, 27, 28, *NOSE, *MOUTH], 2.5),
    "jaw": (JAW, 6.5),
    "mouth": (MOUTH, 6.0),
    "tongueOut": (MOUTH, 6.0),
}

SYMMETRIC = [name for name in EXPRESSIONS if CHANNELS[name].mirror == name]
TOLD = list(MOVES)


@pytest.fixture(scope="module")
def face():
    return embedded_face()


@pytest.fixture(scope="module")
def partner(face):
    where = {tuple(point): number for number, point in enumerate(face.neutral)}
    return np.array([where[tuple(point)] for point in face.neutral * np.float32([-1, 1, 1])])


def shape(face, name):
    return face.shapes[face.shape_names.index(name)]


def landmarks(face, **coefficients):
    values = np.array([[coefficients.get(name, 0) for name in face.shape_names]])
    return face.landmarks_at(face.vertices(values))[0]


def lips_apart(face, **coefficients) -> float:
    points = landmarks(face, **coefficients)
    return float(np.linalg.norm(points[62] - points[66]))


@pytest.mark.parametrize("name", EXPRESSIONS)
def test_the_mirror_image_of_a_channel_is_its_mirror(face, partner, name):
    mirrored = shape(face, name)[partner] * np.float32([-1, 1, 1])
    assert np.array_equal(mirrored, shape(face, CHANNELS[name].mirror))


def test_every_channel_is_told_here_or_by_its_mirror():
    assert set(EXPRESSIONS) == set(TOLD) | {CHANNELS[name].mirror for name in TOLD}


@pytest.mark.parametrize("name", TOLD)
def test_a_channel_moves_what_it_is_named_for(face, name):
    landmark, way = MOVES[name]
    moved = shape(face, name)[face.landmarks[landmark]]
    assert moved @ way > 5e-4  # metres
    if name not in ("mouthClose", "tongueOut", "jawOpen", "mouthFunnel"):
        assert moved @ way > 0.4 * np.linalg.norm(moved)


@pytest.mark.parametrize("name", TOLD)
def test_a_channel_moves_nothing_far_away(face, name):
    numbers, reach = next(told for start, told in REACHES.items() if name.startswith(start))
    offsets = shape(face, name)
    moving = np.linalg.norm(offsets, axis=1) > 5e-4
    assert moving.sum() >= 10
    points = face.neutral.copy()
    if name in SYMMETRIC or name.startswith(("jaw", "mouth")):
        points[:, 0] = np.abs(points[:, 0])
    near = face.neutral[face.landmarks[list(numbers)]]
    away = np.linalg.norm(points[moving][:, None] - near, axis=-1).min(1)
    assert away.max() * 100 < reach


@pytest.mark.parametrize("name", [n for n in TOLD if n.endswith("Left") and n[0] in "ebcn"])
def test_a_channel_of_one_side_leaves_the_other_alone(face, name):
    other = face.neutral[:, 0] < -0.01
    assert np.abs(shape(face, name)[other]).max() < 1e-3


def test_the_jaw_takes_lower_teeth_and_tongue_and_leaves_the_upper(face):
    drop = shape(face, "jawOpen")[:, 1]
    enamel = (face.colours.min(1) > 170) & (face.skin[:, -2:].sum(1) < 0.5)
    height = face.neutral[:, 1]
    mouth = landmarks(face)[62, 1]
    teeth = enamel & (abs(height - mouth) < 0.012) & (face.neutral[:, 2] < 0.09)
    upper = teeth & (height > mouth + 0.003)
    lower = teeth & (height < mouth - 0.003)
    assert upper.sum() > 20
    assert lower.sum() > 20
    assert np.abs(drop[upper]).max() < 1e-6
    assert drop[lower].max() < -0.01


def test_an_open_jaw_parts_the_lips_and_mouth_close_closes_them(face):
    assert lips_apart(face) < 0.001
    assert lips_apart(face, jawOpen=1) > 0.02
    assert lips_apart(face, jawOpen=1, mouthClose=1) < 0.003


def test_a_smile_lifts_and_widens_the_mouth(face):
    rest, smile = landmarks(face), landmarks(face, mouthSmileLeft=1, mouthSmileRight=1)
    assert (smile[[48, 54], 1] - rest[[48, 54], 1] > 0.004).all()
    assert smile[54, 0] - smile[48, 0] > rest[54, 0] - rest[48, 0] + 0.005
    assert np.abs(smile[:48] - rest[:48])[17:].max() < 0.004


def test_a_pucker_narrows_the_mouth_and_pushes_it_forward(face):
    rest, kiss = landmarks(face), landmarks(face, mouthPucker=1)
    assert kiss[54, 0] < 0.7 * rest[54, 0]
    assert kiss[51, 2] > rest[51, 2] + 0.005


def test_the_tongue_comes_out_in_front_of_the_lips(face):
    moved = face.neutral + shape(face, "tongueOut")
    tip = np.linalg.norm(shape(face, "tongueOut"), axis=1).argmax()
    assert moved[tip, 2] > landmarks(face)[[51, 57], 2].max() + 0.005


def test_a_larger_eye_has_a_lid_that_travels_further(face):
    def travel(person):
        one = face.of(person)
        return -shape(one, "eyeBlinkLeft")[one.landmarks[43], 1]

    assert travel({"eyeSize": 1}) > 1.05 * travel({})
    assert travel({"eyeSize": -1}) < 0.95 * travel({})


def test_a_longer_face_has_a_jaw_that_swings_wider(face):
    def swing(person):
        one = face.of(person)
        return np.linalg.norm(shape(one, "jawOpen")[one.landmarks[8]])

    assert swing({"faceLength": 1}) > 1.01 * swing({})
    assert swing({"faceLength": -1}) < 0.99 * swing({})


def test_a_wider_mouth_smiles_where_its_corners_are(face):
    wide = face.of({"mouthWidth": 1})
    lift = shape(wide, "mouthSmileLeft")[wide.landmarks[48:60], 1]
    assert lift.argmax() == 6  # landmark 54, the left corner
