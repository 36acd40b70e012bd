"""How the embedded face looks: what shows in its pictures, told by false colours."""

from dataclasses import replace

import numpy as np
import pytest

from mimeline.face.embedded import embedded_face
from mimeline.face.embedded import mesh as embedded_mesh
from mimeline.face.render import Camera, draw
from mimeline.vocabulary import EXPRESSIONS

GREEN, BLACK = (0, 255, 0), (0, 0, 0)
BOTH = ("Left", "Right")


def drawn(face, coefficients, size=256):
    values = np.array([[coefficients.get(name, 0) for name in face.shape_names]])
    return draw(face, face.vertices(values)[0], Camera.framing(face, size), BLACK).astype(int)


@pytest.fixture(scope="module")
def mesh():
    return embedded_mesh.build()


@pytest.fixture(scope="module")
def pixels(mesh):
    """How many pixels of a picture show some materials."""

    def count(coefficients, *materials) -> int:
        face = embedded_face()
        marked = np.isin(mesh.materials, materials)
        colours = np.where(marked[:, None], GREEN, BLACK).astype(np.uint8)
        picture = drawn(replace(face, colours=colours, gloss=0 * face.gloss), coefficients)
        return int((picture[..., 1] - picture[..., 0] > 40).sum())

    return count


def both(**coefficients) -> dict[str, float]:
    return {stem + side: value for stem, value in coefficients.items() for side in BOTH}


AT_REST = (
    dict.fromkeys((n for n in EXPRESSIONS if n.startswith(("mouth", "jaw"))), 0.06)
    | {"jawLeft": 0.0, "jawRight": 0.0}
    | both(mouthStretch=0.18, mouthFrown=0.18, mouthSmile=0.16)
)


@pytest.mark.parametrize(
    "coefficients",
    [{}, AT_REST, *(both(mouthSmile=value) for value in (0.3, 0.6, 1.0)), both(mouthFrown=1.0)],
    ids=["neutral", "rest", "soft smile", "smile", "broad smile", "frown"],
)
def test_closed_lips_show_no_teeth(pixels, coefficients):
    assert pixels(coefficients, "tooth", "tooth_seam") == 0
    assert pixels({"jawOpen": 0.5} | both(mouthSmile=1.0), "tooth", "tooth_seam") > 40


def test_a_wide_open_mouth_shows_the_upper_teeth(pixels):
    teeth = pixels({"jawOpen": 1.0}, "tooth", "tooth_seam")
    assert 5 < teeth < pixels({"jawOpen": 1.0}, "cavity", "tongue")


def test_each_eye_has_a_spark_of_light_that_stays_where_the_light_is():
    face = embedded_face(iris=(20, 20, 20))
    eyes = Camera.framing(face, 256).project([joint.centre for joint in face.joints[-2:]])
    picture, dull = drawn(face, {}), drawn(replace(face, gloss=None), {})
    for column, row in eyes.astype(int):
        iris = slice(row - 5, row + 6), slice(column - 5, column + 6)
        rows, columns = np.nonzero((picture - dull)[iris].min(-1) > 60)
        assert 1 <= len(rows) < 20
        assert rows.mean() < 5 and columns.mean() < 5  # from the picture's upper left


def test_looking_down_takes_the_upper_lid_along(pixels):
    white = {look: pixels(both(eyeLookDown=look), "sclera") for look in (0.0, 1.0)}
    assert white[1.0] < 0.75 * white[0.0]


def test_gloss_is_as_symmetric_as_the_face(mesh):
    gloss = embedded_face().gloss
    assert np.array_equal(gloss[mesh.partner], gloss)
