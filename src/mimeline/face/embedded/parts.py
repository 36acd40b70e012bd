"""What the embedded face has besides skin, left half: eyeball, teeth, tongue, brow and ear.

Centimetres, frame of anatomy. Each function returns a Part.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from mimeline.face.embedded import anatomy
from mimeline.face.embedded.sculpture import Skin
from mimeline.face.embedded.skin import strips

EYE_SEGMENTS = 14
BROW_ROWS = 4
BROW_COLUMNS = 12
TOOTH_WIDTHS = (0.84, 0.68, 0.76, 0.72, 0.72, 0.9)  # from the midline


@dataclass(frozen=True, eq=False)
class Part:
    """points (n, 3), triangles (f, 3) and what each vertex is made of: materials (n,)."""

    points: np.ndarray
    triangles: np.ndarray
    materials: np.ndarray


def eyeball() -> Part:
    """A ball whose pole is the pupil, with rings on either side of each border of colour."""
    pupil = np.degrees(np.arcsin(anatomy.PUPIL_RADIUS / anatomy.EYE_RADIUS))
    iris = np.degrees(np.arcsin(anatomy.IRIS_RADIUS / anatomy.EYE_RADIUS))
    rings = (
        (pupil - 0.4, "pupil"),
        (pupil + 0.4, "iris_inner"),
        ((pupil + iris) / 2, "iris"),
        (iris - 2.6, "iris"),
        (iris - 0.5, "iris_border"),
        (iris + 0.7, "sclera"),
        (48, "sclera"),
        (75, "sclera"),
        (115, "sclera"),
    )
    polar = np.radians([angle for angle, _ in rings])[:, None]
    turn = 2 * np.pi * np.arange(EYE_SEGMENTS) / EYE_SEGMENTS
    grid = np.stack(
        np.broadcast_arrays(
            -np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), np.cos(polar)
        ),
        axis=-1,
    )  # (rings, segments, 3), clockwise seen from the front
    unit = np.concatenate([[[0, 0, 1.0]], grid.reshape(-1, 3), [[0, 0, -1.0]]])
    numbers = 1 + np.arange(grid.shape[0] * EYE_SEGMENTS).reshape(-1, EYE_SEGMENTS)
    last = len(unit) - 1
    first, back = numbers[0], numbers[-1]
    triangles = np.concatenate(
        [
            strips(numbers, closed=True),
            np.stack([0 * first, np.roll(first, -1), first], axis=-1),
            np.stack([0 * back + last, back, np.roll(back, -1)], axis=-1),
        ]
    )
    materials = ["pupil", *np.repeat([name for _, name in rings], EYE_SEGMENTS), "sclera"]
    return Part(anatomy.EYE + anatomy.EYE_RADIUS * unit, triangles, np.array(materials))


def teeth(upper: bool) -> Part:
    """Half a row of teeth with its gum; enamel is told apart by darker seams."""
    edges = np.concatenate([[0], np.cumsum(TOOTH_WIDTHS)]) * (1.0 if upper else 0.86)
    across, seam = [0.0], [True]
    for left, right in pairwise(edges):
        width = right - left
        across += [left + 0.16 * width, right - 0.16 * width, right]
        seam += [False, False, True]
    across, seam = np.array(across), np.array(seam)
    angle = across / 3.1  # along an arch of that radius
    x = 2.75 * np.sin(angle)
    front = (8.7 if upper else 8.42) - 3.3 * (1 - np.cos(angle)) - 0.05 * seam
    edge, root = (-7.12, -6.15) if upper else (-7.24, -8.0)
    curve = (0.06 if upper else -0.04) * seam + (0.05 if upper else -0.03) * (across / 3) ** 2
    rows = []  # from the gum to the edge and behind it
    for share, out in ((1.6, -0.2), (1.0, 0.03), (0.12, 0.03), (0.0, -0.08), (0.0, -0.53)):
        y = edge + curve * (1 - share) + share * (root - edge)
        rows.append(np.stack([x, y, front + out], axis=-1))
    grid = np.array(rows)
    grid[:, 0, 0] = 0
    numbers = np.arange(grid[..., 0].size).reshape(grid.shape[:2])
    triangles = strips(numbers, closed=False)
    if upper:  # rows run downwards, so turned the other way round
        triangles = triangles[:, ::-1]
    enamel = np.where(seam, "tooth_seam", "tooth")
    gum = np.full(len(seam), "gum")
    materials = np.concatenate([gum, *[enamel] * (len(rows) - 1)])
    return Part(grid.reshape(-1, 3), triangles, materials)


def tongue() -> Part:
    """Half a flattened tongue that lies behind the lower teeth, its tip in front."""
    along = np.linspace(0, 1, 8)
    width = 1.75 * np.clip(1 - np.clip((along - 0.55) / 0.45, 0, 1) ** 2.4, 0, 1) ** 0.5
    width[-1] = 0.02
    thick = 0.55 * np.sqrt(np.maximum(width, 0.02) / 1.75)
    z = 3.6 + 4.55 * along
    middle = -7.95 + 0.35 * np.sin(np.pi * along)
    turn = np.linspace(np.pi / 2, -np.pi / 2, 7)
    x = width[:, None] * np.cos(turn)
    groove = 0.10 * np.exp(-((x / 0.35) ** 2)) * (np.sin(turn) > 0)
    y = middle[:, None] + thick[:, None] * np.sin(turn) - groove * np.minimum(width, 1)[:, None]
    grid = np.stack(np.broadcast_arrays(x, y, z[:, None]), axis=-1)  # (along, round, 3)
    grid[:, [0, -1], 0] = 0
    numbers = np.arange(grid[..., 0].size).reshape(grid.shape[:2])
    triangles = strips(numbers, closed=False)[:, ::-1]
    return Part(grid.reshape(-1, 3), triangles, np.full(grid[..., 0].size, "tongue"))


def brow(skin: Skin) -> Part:
    """Hair that lies flat on the brow ridge, thick within, tapering outwards, thin at its edges."""
    share = np.linspace(0, 1, BROW_COLUMNS)
    x = 1.25 + 4.05 * share
    middle = 1.85 + 0.62 * np.sin(np.pi * share * 0.8) ** 1.3 - 0.35 * share**3
    half = 0.30 * (1 - share**2.2) ** 0.8 * (0.6 + 0.4 * np.minimum(share / 0.15, 1)) + 0.03
    rows = []
    for off, lift in ((-1.3, 0.03), (-0.5, 0.05), (0.5, 0.05), (1.3, 0.03)):
        row = skin.frontal(x + 0.25 * (off + 1) * half * (1 - share), middle + off * half)
        row[:, 2] += lift * np.minimum(1, half / 0.15)
        rows.append(row)
    grid = np.array(rows)
    numbers = np.arange(grid[..., 0].size).reshape(grid.shape[:2])
    materials = np.full(numbers.shape, "brow_edge")
    materials[1:-1, 1:-2] = "brow"
    return Part(grid.reshape(-1, 3), strips(numbers, closed=False), materials.ravel())


def lash(rim: np.ndarray) -> Part:
    """Lashes of the upper lid: a strip from its rim (n, 3), inner to outer corner, forwards."""
    share = np.linspace(0, 1, len(rim))
    length = 0.26 * np.sin(np.pi * (0.02 + 0.80 * share))
    way = np.stack([0.55 * (share - 0.35), 0.55 + 0 * share, 0.75 + 0 * share], axis=-1)
    tips = rim + length[:, None] * way
    roots = rim + np.array([0, 0, 0.01])
    numbers = np.arange(2 * len(rim)).reshape(2, -1)
    return Part(
        np.concatenate([roots, tips]), strips(numbers, closed=False), np.full(numbers.size, "lash")
    )


def ear() -> Part:
    """A simple ear: a shell with a raised rim, tilted backwards."""
    turn = np.linspace(0, 2 * np.pi, 13, endpoint=False)
    wide = 1.55 * (1 + 0.18 * np.sin(turn)) * np.where(np.cos(turn) > 0, 1.05, 0.85)
    outline = np.stack([wide * np.cos(turn), 2.95 * np.sin(turn)], axis=-1)  # back, up
    outline[:, 0] += 0.25 * np.sin(turn) - 0.1
    profile = (  # share of the outline, height above the ear's plane, from the back of the rim in
        (0.62, -0.95),
        (0.94, -0.30),
        (1.0, 0.12),
        (0.90, 0.34),
        (0.76, 0.12),
        (0.58, 0.26),
        (0.40, -0.10),
    )
    rings = np.array(
        [np.column_stack([share * outline, np.full(len(turn), up)]) for share, up in profile[::-1]]
    )  # (rings, columns, 3): back, up, out
    rings[:2, :, 1] -= 0.35
    flat = rings.reshape(-1, 3)
    flat = np.concatenate([flat, [[0, -0.35, -0.38]]])
    front = np.clip(-flat[:, 0] / 1.4, 0, 1)  # the front edge melts into the cheek
    flat[:, 2] -= 0.45 * front
    out = np.array([0.80, 0.02, 0.55])
    out /= np.linalg.norm(out)
    up = np.array([0.06, 0.97, -0.18])
    up -= (up @ out) * out
    up /= np.linalg.norm(up)
    back = np.cross(out, up)
    points = np.array([7.6, -1.45, -0.55]) + flat @ np.array([back, up, out])
    numbers = np.arange(len(flat) - 1).reshape(rings.shape[:2])
    centre, first = len(flat) - 1, numbers[0]
    triangles = np.concatenate(
        [
            strips(numbers, closed=True),
            np.stack([0 * first + centre, np.roll(first, -1), first], axis=-1),
        ]
    )
    return Part(points, triangles, np.full(len(points), "skin"))
