"""The embedded face's parts as one mirrored mesh, with what its movements need to know of it.

Centimetres, frame of anatomy. The left half comes first; its off-midline vertices are repeated,
mirrored, after it.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_array, diags_array
from scipy.sparse.linalg import spsolve
from scipy.spatial import cKDTree

from mimeline.face.embedded import anatomy, parts
from mimeline.face.embedded.sculpture import Skin
from mimeline.face.embedded.skin import BORDER, MEET, SkinMesh
from mimeline.face.embedded.skin import build as build_skin

FAR = 99.0  # from the lips: of what is no skin


@dataclass(frozen=True, eq=False)
class Mesh:
    """points (V, 3) · triangles (F, 3) · materials (V,) names · partner (V,): the vertex on the
    other side, itself on the midline · n_half: vertices of the left half, midline included.

    skin: the left half's skin, which is vertices 0 to len(skin.points).
    part (V,): skin, eye, upper_teeth, lower_teeth, tongue, brow, lash or ear.
    jaw (V,): share of the jaw's movement that a vertex follows.
    below (V,): 0 above the mouth, 1 below; lips are wholly the one or the other.
    lip_distance (V,): how far from the red of the lips.
    soft (V,): 1 where expressions move the flesh, 0 in bone, eyeballs and the depth of the mouth.
    """

    points: np.ndarray
    triangles: np.ndarray
    materials: np.ndarray
    partner: np.ndarray
    n_half: int
    skin: SkinMesh
    part: np.ndarray
    jaw: np.ndarray
    below: np.ndarray
    lip_distance: np.ndarray
    soft: np.ndarray

    def left(self, part: str) -> np.ndarray:
        """Vertex numbers of the left half's eye, brow or other part."""
        return np.flatnonzero(self.part[: self.n_half] == part)

    def mirrored(self, offsets: np.ndarray) -> np.ndarray:
        """Offsets (V, 3) of the mirror image of a movement."""
        return offsets[self.partner] * [-1, 1, 1]

    def symmetric(self, offsets: np.ndarray) -> np.ndarray:
        """Offsets (V, 3) whose right half is the mirror image of the left."""
        both = offsets.copy()
        right = slice(self.n_half, None)
        both[right] = self.mirrored(offsets)[right]
        midline = self.partner == np.arange(len(both))
        both[midline, 0] = 0
        return both


def build() -> Mesh:
    """The whole face at rest."""
    skin, surface = build_skin(), Skin(with_lids=False)
    upper = skin.lids.shape[1] // 2
    named = {
        "skin": parts.Part(skin.points, skin.triangles, _skin_materials(skin)),
        "eye": parts.eyeball(),
        "upper_teeth": parts.teeth(upper=True),
        "lower_teeth": parts.teeth(upper=False),
        "tongue": parts.tongue(),
        "brow": parts.brow(surface),
        "lash": parts.lash(skin.points[skin.lids[1, 1:upper]]),
        "ear": parts.ear(),
    }
    counts = [len(part.points) for part in named.values()]
    starts = np.cumsum([0, *counts[:-1]])
    points = np.concatenate([part.points for part in named.values()])
    triangles = np.concatenate(
        [part.triangles + start for part, start in zip(named.values(), starts, strict=True)]
    )
    n_half = len(points)
    side = np.flatnonzero(points[:, 0] != 0)
    image = np.arange(n_half)  # of the left half's vertices on the right
    image[side] = n_half + np.arange(len(side))
    source = np.concatenate([np.arange(n_half), side])
    points = np.concatenate([points, points[side] * [-1, 1, 1]])
    triangles = np.concatenate([triangles, image[triangles][:, ::-1]])

    part = np.repeat(list(named), counts)
    jaw, below, lip_distance = np.zeros(n_half), np.zeros(n_half), np.full(n_half, FAR)
    n_skin = counts[0]
    jaw[:n_skin], below[:n_skin] = _jaw_weights(skin), _below_weights(skin)
    jaw[np.isin(part, ["lower_teeth", "tongue"])] = 1
    red = skin.points[skin.lips[MEET - 1 : BORDER + 1].ravel()]
    lip_distance[:n_skin] = cKDTree(red).query(skin.points)[0]
    soft = np.isin(part, ["skin", "brow"]).astype(float)
    deep = skin.lips[: MEET - 1]
    soft[deep], lip_distance[deep] = 0, FAR
    return Mesh(
        points=points,
        triangles=triangles,
        materials=np.concatenate([p.materials for p in named.values()])[source],
        partner=np.concatenate([image, side]),
        n_half=n_half,
        skin=skin,
        part=part[source],
        jaw=jaw[source],
        below=below[source],
        lip_distance=lip_distance[source],
        soft=soft[source],
    )


def _skin_materials(skin: SkinMesh) -> np.ndarray:
    materials = np.full(len(skin.points), "skin", dtype="U16")
    materials[skin.in_hair] = "hair"
    materials[skin.in_nostril] = "nostril"
    materials[skin.lips[: MEET - 1]] = "cavity"
    materials[skin.lips[MEET - 1]] = "inner_lip"
    materials[skin.lips[MEET : BORDER + 1]] = "lip"
    upper = skin.lids.shape[1] // 2
    materials[skin.lids[0]] = "inner_lid"
    materials[skin.lids[1:4, upper - 1 : upper + 2]] = "lid_corner"
    materials[skin.lids[0, 6:upper]] = "lash"
    materials[skin.lids[1, 4 : upper + 1]] = "lash"
    return materials


def _jaw_weights(skin: SkinMesh) -> np.ndarray:
    """How much (n,) each vertex of the skin follows the jaw: smooth but for the mouth's slit."""
    x, y, z = skin.points.T
    wanted, trust = np.zeros(len(x)), np.zeros(len(x))
    chin = (y < -9.0) & (y > -11.6) & (z > 6.2)
    wanted[chin], trust[chin] = 1, 0.3
    jaw_line = (y < -8.2) & (y > -10.9) & (z > 2.6) & (z <= 6.2)
    wanted[jaw_line], trust[jaw_line] = 0.85, 0.05
    upper = y > -4.9 - 0.06 * (8 - z)
    still = upper | (z < -0.2) | (y < -13.4)
    trust[still] = 1
    return _smooth(skin, wanted, trust)


def _below_weights(skin: SkinMesh) -> np.ndarray:
    """0 above and 1 below the mouth, (n,), smooth but for the mouth's slit."""
    y = skin.points[:, 1]
    wanted = (y < anatomy.MOUTH[0]).astype(float)
    trust = np.where((y > -5.4) | (y < -8.6), 0.2, 0.0)
    return _smooth(skin, wanted, trust)


def _smooth(skin: SkinMesh, wanted: np.ndarray, trust: np.ndarray) -> np.ndarray:
    """The smoothest numbers (n,) that keep to `wanted` where they are trusted, and part the lips.

    Minimises the squared graph Laplacian (a thin plate) plus trust times squared difference.
    """
    lips = skin.lips
    columns = lips.shape[1]
    way = np.linspace(-1, 1, columns)  # -1 above and 1 below on the midline, 0 in the corner
    part = 0.5 + 0.5 * np.sign(way) * (1 - (1 - np.abs(way)) ** 2.2)
    wanted, trust = wanted.copy(), trust.copy()
    wanted[lips[: BORDER + 1]], trust[lips[: BORDER + 1]] = part, 50
    edges = np.concatenate([skin.triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
    edges = np.concatenate([edges, edges[:, ::-1]])
    gap = np.linalg.norm(skin.points[edges[:, 0]] - skin.points[edges[:, 1]], axis=1)
    n = len(skin.points)
    weight = csc_array((1 / np.maximum(gap, 0.1), edges.T), shape=(n, n))
    laplacian = diags_array(1 / weight.sum(1)) @ weight - diags_array(np.ones(n))
    system = laplacian.T @ laplacian + diags_array(trust + 1e-9)
    return np.clip(spsolve(system.tocsc(), trust * wanted), 0, 1)
