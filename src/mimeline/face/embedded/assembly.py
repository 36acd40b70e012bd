"""The face that comes with mimeline: made wholly by code, with the 52 ARKit blendshapes.

Its parts are told in anatomy, its surface in sculpture and skin, its movements in expressions and
what makes persons differ in identities.
"""

from functools import cache

import numpy as np

from mimeline.face.embedded import anatomy, expressions, identities
from mimeline.face.embedded.mesh import Mesh
from mimeline.face.embedded.mesh import build as build_mesh
from mimeline.face.embedded.parts import BROW_ROWS
from mimeline.face.embedded.skin import BORDER, MEET
from mimeline.face.falloff import smoothstep
from mimeline.face.model import SKIN_GLOSS, Face, Joint
from mimeline.vocabulary import EXPRESSIONS

SKIN_TONE, HAIR, IRIS = (228, 180, 152), (74, 50, 36), (92, 122, 128)
METRES = 0.01  # in a centimetre
GLOSS = {  # of materials that are not as skin; the dark holds no reflections
    **dict.fromkeys(("pupil", "iris_inner", "iris", "iris_border", "sclera"), 1.0),
    **dict.fromkeys(("tooth", "tooth_seam", "tongue"), 0.25),
    "lip": 0.12,
    **dict.fromkeys(("cavity", "gum", "inner_lip", "nostril"), 0.0),
}
MOUTH_DEPTHS = (4.6, 8.5)  # how far forward light reaches nothing, and all, of the mouth's inside

Colour = tuple[int, int, int]


@cache
def embedded_face(skin: Colour = SKIN_TONE, hair: Colour = HAIR, iris: Colour = IRIS) -> Face:
    """The embedded face; skin, hair and iris are sRGB triples, lips and brows derive from them.

    Shapes are vocabulary.EXPRESSIONS, identities are identities.NAMES with correctives, joints are
    neck (which stays), head, left_eye and right_eye. eyeLook shapes move the lids alone: the balls
    are turned by their joints.
    """
    mesh, arrays = _geometry()
    return Face(colours=_colours(mesh, skin, hair, iris), **arrays)


@cache
def _geometry() -> tuple[Mesh, dict]:
    """The mesh and every array of the Face but its colours."""
    mesh = build_mesh()
    neutral = mesh.points
    shapes = expressions.shapes(mesh, neutral)
    persons = identities.offsets(mesh)
    correctives = np.array(
        [expressions.shapes(mesh, neutral + person) - shapes for person in persons], np.float32
    )
    centres = {
        "neck": anatomy.NECK_AT,
        "head": anatomy.HEAD_AT,
        "left_eye": anatomy.EYE,
        "right_eye": np.array(anatomy.EYE) * [-1, 1, 1],
    }
    joints = [
        Joint(name, parent, np.array(centre) * METRES)
        for (name, centre), parent in zip(centres.items(), (None, 0, 1, 1), strict=True)
    ]
    return mesh, {
        "neutral": neutral * METRES,
        "triangles": mesh.triangles,
        "shapes": shapes * METRES,
        "shape_names": EXPRESSIONS,
        "identities": persons * METRES,
        "identity_names": identities.NAMES,
        "correctives": correctives * METRES,
        "landmarks": _landmarks(mesh),
        "joints": joints,
        "skin": _weights(mesh),
        "gloss": [GLOSS.get(material, SKIN_GLOSS) for material in mesh.materials],
    }


def _weights(mesh: Mesh) -> np.ndarray:
    """Skinning weights (V, 4): the neck's lower end stays, the eyeballs are the eyes' alone."""
    head = smoothstep(mesh.points[:, 1], anatomy.NECK_BOTTOM, anatomy.NECK_BOTTOM + 3.2)
    is_eye = mesh.part == "eye"
    left = is_eye & (mesh.points[:, 0] > 0)
    right = is_eye & ~left
    weights = np.stack([1 - head, head, left, right], axis=-1)
    weights[is_eye, :2] = 0
    return weights


def _colours(mesh: Mesh, skin: Colour, hair: Colour, iris: Colour) -> np.ndarray:
    """sRGB (V, 3) of every vertex."""
    skin, hair, iris = (np.array(colour, float) for colour in (skin, hair, iris))
    lip, brow = skin * [0.87, 0.68, 0.69], 0.85 * hair + 0.15 * skin * 0.6
    palette = {
        "skin": skin,
        "hair": hair,
        "brow": brow,
        "brow_edge": 0.15 * brow + 0.85 * skin,
        "lash": 0.35 * hair + 8,
        "lip": lip,
        "inner_lip": lip * [0.6, 0.42, 0.42],
        "lid_corner": skin * [0.88, 0.80, 0.78],
        "inner_lid": skin * [0.95, 0.76, 0.74],
        "nostril": skin * [0.52, 0.40, 0.38],
        "cavity": np.array([58, 20, 20]),
        "tooth": np.array([244, 238, 226]),
        "tooth_seam": np.array([206, 192, 176]),
        "gum": np.array([188, 104, 104]),
        "tongue": np.array([190, 96, 96]),
        "sclera": np.array([240, 237, 232]),
        "iris": iris,
        "iris_inner": np.minimum(iris * 1.25 + 10, 255),
        "iris_border": iris * 0.5,
        "pupil": np.array([14, 12, 14]),
    }
    colours = np.array([palette[material] for material in mesh.materials])
    inside = np.isin(mesh.materials, ["cavity", "tooth", "tooth_seam", "gum", "tongue"])
    reached = 0.2 + 0.8 * smoothstep(mesh.points[inside, 2], *MOUTH_DEPTHS)
    colours[inside] *= reached[:, None]
    return np.clip(np.rint(colours), 0, 255).astype(np.uint8)


def _landmarks(mesh: Mesh) -> np.ndarray:
    """Vertex numbers (68,) in the iBUG order, found on the left half and mirrored."""
    skin, points = mesh.skin, mesh.points[: mesh.n_half]
    surface = mesh.left("skin")
    surface = np.setdiff1d(surface, skin.lips[:MEET])
    midline = surface[points[surface, 0] == 0]

    def nearest(where, among=surface) -> int:
        return int(among[((points[among] - where) ** 2).sum(1).argmin()])

    jaw = [nearest(where) for where in anatomy.JAW_LINE] + [nearest((0, -11.2, 7.9), midline)]
    columns = mesh.left("brow").reshape(BROW_ROWS, -1)[2]
    brow = columns[np.linspace(0, len(columns) - 1, 5).round().astype(int)]  # inner to outer
    bridge = [nearest(where, midline) for where in anatomy.NOSE_BRIDGE]
    base = [
        nearest((0, -4.55, 9.9), midline),
        nearest((0.62, -4.5, 9.75)),
        nearest((1.35, -4.4, 9.3)),
    ]
    rim = skin.lids[1]
    half = len(rim) // 2
    upper = [rim[0], rim[round(half * 0.36)], rim[round(half * 0.64)], rim[half]]
    lower = [rim[half + round(half * 0.36)], rim[half + round(half * 0.64)]]  # outer, inner
    border, meet = skin.lips[BORDER], skin.lips[MEET]
    side = len(border) // 2
    bow = round(side * 0.18) or 1
    outer_top = [border[0], border[bow], border[round(side * 0.55)]]
    outer_low = [border[-1], border[-1 - round(side * 0.25)], border[-1 - round(side * 0.55)]]
    inner_top = [meet[0], meet[round(side * 0.4)]]
    inner_low = [meet[-1], meet[-1 - round(side * 0.4)]]
    right = mesh.partner
    return np.array(
        [
            *(right[jaw[:-1]]),
            jaw[-1],
            *jaw[-2::-1],
            *right[brow[::-1]],
            *brow,
            *bridge,
            *right[[base[2], base[1]]],
            *base,
            *right[[upper[3], upper[2], upper[1], upper[0], lower[1], lower[0]]],
            *upper,
            *lower,
            right[border[side]],
            *right[outer_top[:0:-1]],
            *outer_top,
            border[side],
            *outer_low[:0:-1],
            outer_low[0],
            *right[outer_low[1:]],
            right[meet[side]],
            right[inner_top[1]],
            *inner_top,
            meet[side],
            inner_low[1],
            inner_low[0],
            right[inner_low[1]],
        ]
    )
