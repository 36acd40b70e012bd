"""The skin of the embedded face's left half as a mesh: rings round eye and mouth, the rest filled.

Centimetres, frame of anatomy.
"""

from dataclasses import dataclass

import numpy as np

from mimeline.face.embedded import anatomy, hair
from mimeline.face.embedded.sculpture import CENTRE, Skin, directions
from mimeline.face.embedded.tessellation import filled, spacing, triangulated

LID_COLUMNS = 14  # from corner to corner; the lower lid has as many
LID_RINGS = (0.0, 0.0, 0.07, 0.2, 0.42, 0.7, 1.0)  # 0 the rim (inner, outer), 1 the socket
LIP_COLUMNS = 12  # from the midline to the corner, both counted
LIP_ROWS = (0.0, 0.35, 0.7, 1.0)  # from where the lips meet to the border of the red
LIP_BULGE = (0.04, 0.36, 0.40, 0.13)  # of each, out of the face
ROWS_BEHIND = 3  # from the throat to the back of the lips
MEET, BORDER = ROWS_BEHIND, ROWS_BEHIND + len(LIP_ROWS) - 1  # rows of SkinMesh.lips
NECK_COLUMNS = 15


@dataclass(frozen=True, eq=False)
class SkinMesh:
    """Half a head: points (n, 3), triangles (f, 3) counter-clockwise seen from outside.

    lids (rings, columns): vertex numbers, from the rim outwards; columns run from the inner corner
    over the upper lid to the outer corner and back.
    lips (rows, columns): vertex numbers, from the throat outwards over MEET, where the lips meet,
    and BORDER, where the red ends; columns run from the midline over the upper lip to the corner
    and back below.
    in_hair, in_nostril (n,): bool.
    """

    points: np.ndarray
    triangles: np.ndarray
    lids: np.ndarray
    lips: np.ndarray
    in_hair: np.ndarray
    in_nostril: np.ndarray


def build() -> SkinMesh:
    """The skin of the left half, hair included."""
    skin = Skin()
    lids, lips, nostril = _eye_rings(skin), _mouth_rows(skin), _nostril(skin)
    lines = [
        _midline(skin, lips[-1]),
        _neck_bottom(skin),
        skin.radial(directions(np.array(anatomy.JAW_LINE))),
        hair.hairline_rows(skin),
    ]
    holes = [lids[-1], lips[-1]]
    filling = filled(skin, np.concatenate([*holes, nostril, *lines]), holes)

    # the outermost rings stand once, at the beginning of the filling
    inner_lids, inner_lips = lids[:-1].reshape(-1, 3), lips[:-1].reshape(-1, 3)
    points = np.concatenate([inner_lids, inner_lips, filling])
    numbers = np.arange(len(points))
    lid_end, start = len(inner_lids), len(inner_lids) + len(inner_lips)
    lip_start, nostril_start = start + len(lids[-1]), start + len(lids[-1]) + len(lips[-1])
    lid_numbers = np.concatenate([numbers[:lid_end], numbers[start:lip_start]])
    lid_numbers = lid_numbers.reshape(lids.shape[:2])
    lip_numbers = np.concatenate([numbers[lid_end:start], numbers[lip_start:nostril_start]])
    lip_numbers = lip_numbers.reshape(lips.shape[:2])
    triangles = [
        strips(lid_numbers, closed=True),
        strips(lip_numbers, closed=False),
        _throat(lip_numbers[0]),
        start + triangulated(filling, holes),
    ]
    depth = np.where(numbers < start, -1, hair.depth_inside(points))
    in_nostril = np.isin(numbers, nostril_start + np.arange(len(nostril)))
    points = hair.raised(points, depth)
    points[in_nostril] += [0, 0.05, -0.12]
    return SkinMesh(
        points, np.concatenate(triangles), lid_numbers, lip_numbers, depth > 0, in_nostril
    )


def strips(numbers: np.ndarray, closed: bool) -> np.ndarray:
    """Triangles between neighbouring rows of vertex numbers (rows, columns).

    closed: whether the last column meets the first. Counter-clockwise where columns run clockwise
    and rows run outwards.
    """
    here, there = (numbers, np.roll(numbers, -1, axis=1))
    if not closed:
        here, there = here[:, :-1], there[:, :-1]
    a, b, c, d = here[:-1], there[:-1], there[1:], here[1:]
    return np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)


def _throat(row: np.ndarray) -> np.ndarray:
    """Triangles that close the back of the mouth between the halves of its last row."""
    middle = len(row) // 2
    quads = strips(np.stack([row[middle:][::-1], row[: middle + 1]]), closed=False)
    return np.delete(quads, -2, axis=0)  # the halves share the corner: there, half a quad is left


def _opening(across: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Heights of the upper and lower lid's rim at across in [-1 inner, 1 outer corner]."""
    corners = 0.10 * across + 0.02
    arch = np.clip(1 - across**2, 0, 1)
    upper = corners + anatomy.UPPER_LID * arch**0.72 * (1 - 0.08 * across)
    lower = corners - anatomy.LOWER_LID * arch**0.85 * (1 + 0.10 * across)
    return upper, lower


def _eye_rings(skin: Skin) -> np.ndarray:
    """Rings round the left eye (rings, columns, 3), from the rim on the ball to the socket."""
    n, eye, stage = LID_COLUMNS, np.array(anatomy.EYE), np.array(LID_RINGS)[:, None]
    across = -np.cos(np.pi * np.arange(n + 1) / n)  # (n + 1,)
    upper, lower = _opening(across)
    there_and_back = np.concatenate([across, across[-2:0:-1]])  # (2n,)
    rim_x = eye[0] + anatomy.LID_CORNER * there_and_back
    rim_y = np.concatenate([upper, lower[-2:0:-1]])
    angle = np.pi * (1 - np.arange(2 * n) / n)
    socket_x = eye[0] + 0.12 + 2.0 * np.cos(angle)
    socket_y = np.where(np.sin(angle) > 0, 1.35, 1.4) * np.sin(angle)
    x = (1 - stage) * rim_x + stage * socket_x  # (rings, 2n)
    y = (1 - stage) * rim_y + stage * socket_y
    rings = skin.frontal(x.ravel(), y.ravel()).reshape(*x.shape, 3)
    behind = anatomy.EYE_RADIUS**2 - 0.08 - (rim_x - eye[0]) ** 2 - (rim_y - eye[1]) ** 2
    rings[0, :, 2] = eye[2] + np.sqrt(np.maximum(behind, 0.25))  # tucked under the ball's surface
    crease = np.exp(-(((stage - 0.40) / 0.10) ** 2)) * np.clip(np.sin(angle), 0, 1) ** 0.5
    rings[..., 2] -= 0.10 * crease
    return rings


def _mouth_rows(skin: Skin) -> np.ndarray:
    """Rows round the left half of the mouth (rows, columns, 3), from the throat outwards."""
    quarter = np.sin(np.linspace(0, np.pi / 2, LIP_COLUMNS))
    across = np.concatenate([quarter, quarter[-2::-1]])  # (2 LIP_COLUMNS - 1,), 1 at the corner
    side = np.sign(np.linspace(1, -1, len(across)))  # 1 above, -1 below, 0 at the corner
    taper = np.clip(1 - across**2, 0, 1)
    bow = 0.10 * np.exp(-(((across - 0.24) / 0.16) ** 2)) - 0.07 * np.exp(-((across / 0.10) ** 2))
    upper, lower = anatomy.UPPER_LIP * taper**0.55 + bow, anatomy.LOWER_LIP * taper**0.45
    red = side * np.where(side > 0, upper, lower)  # height of the red
    dip = 0.03 - 0.09 * np.exp(-((across / 0.28) ** 2)) + 0.12 * across**4
    middle, corner = anatomy.MOUTH
    line = middle + dip  # where the lips meet

    def on_skin(x: np.ndarray, y: np.ndarray, lift: np.ndarray) -> np.ndarray:
        return skin.frontal(x, y) + lift[:, None] * [0, 0, 1]

    fullness = np.where(side < 0, 1.12, 1.0) * taper**0.55
    lips = [
        on_skin(across * (corner + 0.10 * stage), line + stage * red, bulge * fullness)
        for stage, bulge in zip(LIP_ROWS, LIP_BULGE, strict=True)
    ]
    around = [
        on_skin(
            across * (corner + 0.10 + 1.05 * out),
            line + red + side * out * (0.35 + 0.65 * taper**0.4),
            lift * taper,
        )
        for out, lift in ((0.07, 0.12), (0.35, 0.04), (0.75, 0.0))
    ]
    rise = np.where(side < 0, 0.30, 0.12) * taper**0.5  # the lower lip rolls up behind the upper
    behind = lips[0] * [0.97, 1, 1] + np.stack([0 * side, rise, -0.45 + 0 * side], axis=-1)
    wide = side * taper**0.5
    cheek = np.stack([2.9 * across, middle + wide, 7.4 - 1.3 * across**2], axis=-1)
    throat = np.stack([1.9 * across, middle - 0.1 + 0.9 * wide, 4.2 + 0 * across], axis=-1)
    return np.array([throat, cheek, behind, *lips, *around])


def _nostril(skin: Skin) -> np.ndarray:
    """The nostril's middle and a ring round it (7, 3), on the underside of the nose."""
    angle = 2 * np.pi * np.arange(6) / 6
    x = 0.56 + np.concatenate([[0], 0.24 * np.cos(angle)])
    z = 9.95 + np.concatenate([[0], 0.27 * np.sin(angle)])
    above = np.stack([x, np.full_like(x, -3.6), z], axis=-1)
    return np.concatenate([skin.cast(point, np.array([[0.0, -1.0, 0.0]])) for point in above])


def _midline(skin: Skin, around_mouth: np.ndarray) -> np.ndarray:
    """Points (n, 3) on the midline, from the mouth over nose and crown to the neck, and below."""

    def angle(point: np.ndarray) -> float:  # about +X: 0 forward, pi / 2 up
        return float(np.arctan2(point[1] - CENTRE[1], point[2] - CENTRE[2]))

    def at(angles: np.ndarray) -> np.ndarray:
        return skin.radial(np.stack([0 * angles, np.sin(angles), np.cos(angles)], axis=-1))

    def walk(start: float, end: float) -> np.ndarray:
        angles = np.linspace(start, end, 700)
        path = at(angles)
        steps = np.linalg.norm(np.diff(path, axis=0), axis=1) / spacing(path)[1:]
        walked = np.concatenate([[0], np.cumsum(steps)])
        count = round(walked[-1])
        return at(np.interp(np.arange(1, count) / count * walked[-1], walked, angles))

    foot = np.array([0, anatomy.NECK_BOTTOM, -1.5])
    front, back = skin.cast(foot, np.array([[0, 0, 1.0], [0, 0, -1.0]]))
    above = walk(angle(around_mouth[0]), angle(back) + 2 * np.pi)
    below = walk(angle(around_mouth[-1]), angle(front))
    path = np.concatenate([above, below]) * [0, 1, 1]
    return path[np.abs(hair.depth_inside(path)) > 0.4]


def _neck_bottom(skin: Skin) -> np.ndarray:
    angle = np.linspace(0, np.pi, NECK_COLUMNS)
    rays = np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=-1)
    points = skin.cast(np.array([0, anatomy.NECK_BOTTOM, -1.5]), rays)
    points[[0, -1], 0] = 0
    return points
