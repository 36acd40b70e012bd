"""Which points of two faces are the same part of a face, whatever their topologies."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import RBFInterpolator
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from mimeline.face.model import Face
from mimeline.face.raster import vertex_normals

AGREEING = 0.5  # cosine between the normals of partners
NEAR = 0.16  # distances between the eyes: partners lie no further apart
TRIMMED = 0.8  # share of the points, the nearest, that an alignment is made from
ROUNDS = 20  # of the alignment
CANDIDATES = 12  # triangles that are looked at for each point
REACHES = (
    0.5,
    0.25,
    0.12,
)  # distances between the eyes, over which the surfaces are drawn together
ON_EYE = 0.5  # weight of a joint of the eyes: more is eyeball
LEAST = 50  # partners that two faces have
MERGED = 1e-6  # metres


@dataclass(frozen=True, eq=False)
class Correspondence:
    """vertices (n,): numbers in the target · corners (n, 3), shares (n, 3): vertices of the source
    and their shares, whose weighted mean is the same point · turn (3, 3): brings the source's
    offsets to the target's size and frame.
    """

    vertices: np.ndarray
    corners: np.ndarray
    shares: np.ndarray
    turn: np.ndarray

    def carried(self, offsets: np.ndarray) -> np.ndarray:
        """Offsets (S, n, 3) at the target's vertices of the source's offsets (S, V, 3)."""
        at = np.einsum("snkx,nk->snx", offsets[:, self.corners], self.shares)  # (S, n, 3)
        return at @ self.turn.T


def correspondence(source: Face, target: Face) -> Correspondence:
    """The partners on the source's surface of the target's skin.

    The faces are brought together by a similarity: through their 68 landmarks, else through their
    eyes, then by iterated closest points. The target's points are drawn to the source's surface
    through landmarks and, ever more locally, closest points. A vertex whose partner is far or
    faces elsewhere is left out. Faces of one topology are partners vertex by vertex.
    Raises ValueError where hardly any point has a partner: these are not two faces.
    """
    if np.array_equal(source.triangles, target.triangles):
        every = np.arange(len(target.neutral))
        corners = np.repeat(every[:, None], 3, axis=1)
        return Correspondence(every, corners, np.tile([1.0, 0, 0], (len(every), 1)), np.eye(3))
    surface = _Surface(source)
    numbers = np.flatnonzero(_skin(target))
    points = np.float64(target.neutral[numbers])
    normals = _normals(target)[numbers]
    scale, turn, shift = _aligned(source, target, surface, points, normals)
    points = scale * points @ turn.T + shift
    normals = normals @ turn.T
    between = scale * _between_eyes(target)
    if source.landmarks is not None and target.landmarks is not None:
        marks = scale * np.float64(target.neutral[target.landmarks]) @ turn.T + shift
        points = points + _warp(marks, np.float64(source.neutral[source.landmarks]), points)
    for reach in REACHES:
        partner = surface.nearest(points, normals)
        near = _enough(partner.distance < 2 * NEAR * between)
        points = points + _smoothed(points, partner.points - points, near, reach * between)
    partner = surface.nearest(points, normals)
    near = _enough(partner.distance < NEAR * between)
    return Correspondence(
        numbers[near], partner.corners[near], partner.shares[near], turn.T / scale
    )


@dataclass(frozen=True, eq=False)
class _Partners:
    points: np.ndarray
    corners: np.ndarray
    shares: np.ndarray
    distance: np.ndarray


class _Surface:
    """A face's skin, to which closest points are looked for."""

    def __init__(self, face: Face):
        self.points = np.float64(face.neutral)
        self.triangles = face.triangles[_skin(face)[face.triangles].all(1)]
        a, b, c = (self.points[self.triangles[:, k]] for k in range(3))
        normal = np.cross(b - a, c - a)
        length = np.linalg.norm(normal, axis=1)
        self.triangles, normal = self.triangles[length > 0], normal[length > 0]
        self.normals = normal / length[length > 0, None]
        self.tree = cKDTree(self.points[self.triangles].mean(1))

    def nearest(self, points: np.ndarray, normals: np.ndarray) -> _Partners:
        """The nearest places on triangles that face as the points (n, 3) do; else far away."""
        k = min(CANDIDATES, len(self.triangles))
        _, near = self.tree.query(points, k=k)  # (n, k)
        near = near.reshape(len(points), k)
        corners = self.points[self.triangles[near]]  # (n, k, 3, 3)
        shares = _closest_shares(points[:, None], corners)  # (n, k, 3)
        places = np.einsum("nkc,nkcx->nkx", shares, corners)
        distance = np.linalg.norm(places - points[:, None], axis=2)
        facing = np.einsum("nkx,nx->nk", self.normals[near], normals) > AGREEING
        best = np.where(facing, distance, np.inf).argmin(1)
        rows = np.arange(len(points))
        return _Partners(
            places[rows, best],
            self.triangles[near[rows, best]],
            shares[rows, best],
            np.where(facing, distance, np.inf)[rows, best],
        )


def _closest_shares(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Barycentric shares (..., 3) of where triangles (..., 3, 3) are nearest to points (..., 3)."""
    a, b, c = (corners[..., k, :] for k in range(3))
    ab, ac, ap = b - a, c - a, points - a

    def dot(x, y):
        return (x * y).sum(-1)

    d00, d01, d11, d20, d21 = dot(ab, ab), dot(ab, ac), dot(ac, ac), dot(ap, ab), dot(ap, ac)
    bottom = np.maximum(d00 * d11 - d01 * d01, np.finfo(float).tiny)
    v, w = (d11 * d20 - d01 * d21) / bottom, (d00 * d21 - d01 * d20) / bottom
    inner = np.stack([1 - v - w, v, w], axis=-1)
    options = []
    for start, end in ((0, 1), (1, 2), (2, 0)):  # the edges
        p, q = corners[..., start, :], corners[..., end, :]
        along = q - p
        share = np.clip(dot(points - p, along) / np.maximum(dot(along, along), 1e-300), 0, 1)
        edge = np.zeros_like(inner)
        edge[..., start], edge[..., end] = 1 - share, share
        options.append(edge)
    options = np.stack(options, axis=-2)  # (..., 3 edges, 3)
    places = np.einsum("...ec,...cx->...ex", options, corners)
    best = ((places - points[..., None, :]) ** 2).sum(-1).argmin(-1)
    on_edge = np.take_along_axis(options, best[..., None, None], axis=-2)[..., 0, :]
    return np.where((inner >= 0).all(-1, keepdims=True), inner, on_edge)


def _aligned(
    source: Face, target: Face, surface: _Surface, points: np.ndarray, normals: np.ndarray
) -> tuple[float, np.ndarray, np.ndarray]:
    """Scale, turn (3, 3) and shift (3,) that bring the target to the source."""
    if source.landmarks is not None and target.landmarks is not None:
        return _similarity(target.neutral[target.landmarks], source.neutral[source.landmarks])
    ours, theirs = _eyes(target), _eyes(source)
    apart = np.linalg.norm(theirs[0] - theirs[1]) / np.linalg.norm(ours[0] - ours[1])
    scale, turn, shift = apart, np.eye(3), theirs.mean(0) - apart * ours.mean(0)
    for _ in range(ROUNDS):
        moved = scale * points @ turn.T + shift
        partner = surface.nearest(moved, normals @ turn.T)
        seen = np.isfinite(partner.distance)
        used = partner.distance <= np.quantile(partner.distance[_enough(seen)], TRIMMED)
        scale, turn, shift = _similarity(points[used], partner.points[used])
    if not 0.5 < scale / apart < 2:
        raise ValueError(
            f"surfaces that fit each other at {scale / apart:.2g} of the eyes' distance"
        )
    return scale, turn, shift


def _enough(partners: np.ndarray) -> np.ndarray:
    """The same (n,) bool. Raises ValueError where they are too few."""
    if partners.sum() < LEAST:
        raise ValueError(f"only {partners.sum()} points of one face are near the other")
    return partners


def _similarity(a: np.ndarray, b: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """Scale, turn and shift from points a to b, (n, 3) each (Umeyama 1991, equations 40-42)."""
    a, b = np.float64(a), np.float64(b)
    from_a, from_b = a - a.mean(0), b - b.mean(0)
    u, strength, vt = np.linalg.svd(from_b.T @ from_a)
    sign = np.array([1, 1, np.sign(np.linalg.det(u @ vt))])
    turn = (u * sign) @ vt
    scale = float((strength * sign).sum() / (from_a**2).sum())
    return scale, turn, b.mean(0) - scale * turn @ a.mean(0)


def _eyes(face: Face) -> np.ndarray:
    """(2, 3): the left and the right eye's centre."""
    names = face.joint_names
    if "left_eye" in names and "right_eye" in names:
        centres = [face.joints[names.index(side)].centre for side in ("left_eye", "right_eye")]
        return np.float64(centres)
    if face.landmarks is not None:
        corners = np.float64(face.neutral[face.landmarks])
        return np.stack([corners[42:48].mean(0), corners[36:42].mean(0)])
    raise ValueError("the face has neither joints left_eye and right_eye nor landmarks")


def _between_eyes(face: Face) -> float:
    return float(np.linalg.norm(np.subtract(*_eyes(face))))


def _skin(face: Face) -> np.ndarray:
    """(V,) bool: the largest connected part, without eyeballs."""
    V = len(face.neutral)
    _, place = np.unique(np.rint(face.neutral / MERGED), axis=0, return_inverse=True)
    edges = place.reshape(-1)[face.triangles]  # vertices in one place are one
    rows, columns = edges.ravel(), np.roll(edges, 1, axis=1).ravel()
    graph = coo_array((np.ones(len(rows)), (rows, columns)), (V, V))
    part = connected_components(graph, directed=False)[1][place.reshape(-1)]
    used = np.zeros(V, bool)
    used[face.triangles] = True
    eyes = [n for n, name in enumerate(face.joint_names) if name in ("left_eye", "right_eye")]
    used &= face.skin[:, eyes].sum(1) < ON_EYE
    if not used.any():
        raise ValueError("a face without a surface")
    return used & (part == np.bincount(part[used]).argmax())


def _normals(face: Face) -> np.ndarray:
    return np.float64(vertex_normals(np.float32(face.neutral), face.triangles))


def _warp(marks: np.ndarray, wanted: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Shifts (n, 3) of points that bring marks (m, 3) to where they are wanted, smoothly."""
    _, first = np.unique(marks, axis=0, return_index=True)
    spline = RBFInterpolator(marks[first], (wanted - marks)[first], kernel="linear")
    return spline(points)


def _smoothed(points, shifts, trusted, reach: float) -> np.ndarray:
    """Shifts (n, 3), each the mean over its neighbours that are trusted, by their nearness."""
    tree = cKDTree(points[trusted])
    k = min(64, int(trusted.sum()))
    distance, near = tree.query(points, k=k)
    weight = np.exp(-((distance / reach) ** 2)) + 1e-12
    weight /= weight.sum(1, keepdims=True)
    return np.einsum("nk,nkx->nx", weight, shifts[trusted][near])
