"""Vertices and triangles that fill the head between the rings and lines that are given.

Centimetres, frame of anatomy; only the left half (x >= 0).
"""

import numpy as np
from scipy.spatial import ConvexHull, cKDTree

from mimeline.face.embedded.anatomy import DENSE, NECK_BOTTOM
from mimeline.face.embedded.sculpture import Skin, directions

CANDIDATES = 5000  # over the whole sphere of directions, before the denser ones in front
ROUNDS = 5  # of moving each point amid its neighbours
SMALLEST, LARGEST, GROWTH = 0.3, 1.2, 0.19  # spacing, and what a centimetre of distance adds


def spacing(points: np.ndarray) -> np.ndarray:
    """How far apart (n,) vertices should lie at points (n, 3)."""
    places, sizes = np.array([place for place, _ in DENSE]), np.array([size for _, size in DENSE])
    away = np.linalg.norm(points[:, None] - places, axis=-1)  # (n, places)
    return np.clip((sizes + GROWTH * np.maximum(away - 1, 0)).min(1), SMALLEST, LARGEST)


def filled(skin: Skin, fixed: np.ndarray, holes: list[np.ndarray]) -> np.ndarray:
    """fixed (m, 3) and, after them, points that fill the rest of the skin at their spacing.

    holes: rings (k, 3) of the face that stay empty inside.
    """
    candidates = skin.radial(_candidate_directions(skin))
    wanted = spacing(candidates)
    usable = cKDTree(fixed).query(candidates)[0] > 0.8 * wanted
    usable &= (candidates[:, 1] > NECK_BOTTOM + 0.5) & (candidates[:, 0] > 0.45 * wanted)
    for hole in holes:
        usable &= ~_within(candidates, hole)
    points = np.concatenate([fixed, _thinned(candidates[usable], wanted[usable])])
    free = slice(len(fixed), None)
    for _ in range(ROUNDS):
        triangles = triangulated(points, holes)
        edges = np.concatenate([triangles, triangles[:, ::-1]])
        total, count = np.zeros_like(points), np.zeros((len(points), 1))
        for here, there in ((0, 1), (1, 2), (2, 0)):
            np.add.at(total, edges[:, here], points[edges[:, there]])
            np.add.at(count, edges[:, here], 1)
        points[free] = skin.radial(directions((total / np.maximum(count, 1))[free]))
    return points


def triangulated(points: np.ndarray, holes: list[np.ndarray]) -> np.ndarray:
    """Triangles (f, 3) of half a head with points (n, 3), counter-clockwise seen from outside.

    Delaunay's on the sphere of directions, less those in holes and under the neck.
    """
    side = points[points[:, 0] > 0]
    both = np.concatenate([points, side * [-1, 1, 1]])
    rays = directions(both)
    triangles = ConvexHull(rays).simplices
    a, b, c = rays[triangles].transpose(1, 0, 2)
    inwards = (np.cross(b - a, c - a) * (a + b + c)).sum(1) < 0
    triangles[inwards] = triangles[inwards][:, ::-1]
    keep = (triangles < len(points)).all(1)
    keep &= ~(both[triangles][..., 1] < NECK_BOTTOM + 0.01).all(1)
    middle = both[triangles].mean(1)
    for hole in holes:
        keep &= ~_within(middle, hole)
    return triangles[keep]


def _candidate_directions(skin: Skin) -> np.ndarray:
    """Unit directions (n, 3) into the left half, many to the nose and mouth: a Fibonacci sphere."""
    number = np.arange(CANDIDATES)
    up = 1 - 2 * (number + 0.5) / CANDIDATES
    turn, level = number * np.pi * (3 - np.sqrt(5)), np.sqrt(1 - up**2)
    sphere = np.stack([level * np.cos(turn), up, level * np.sin(turn)], axis=-1)
    across, rise = np.meshgrid(np.arange(0.1, 3, 0.11), np.arange(-6, 2, 0.11))
    front = directions(skin.frontal(across.ravel(), rise.ravel()))
    return np.concatenate([sphere[sphere[:, 0] > 0], front])


def _thinned(points: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Points of which no two are nearer to each other than their spacing, densest first."""
    order = np.lexsort((points[:, 1], wanted.round(2)))
    points, wanted = points[order], wanted[order]
    near = cKDTree(points)
    free, chosen = np.ones(len(points), bool), []
    for number in range(len(points)):
        if free[number]:
            chosen.append(number)
            free[near.query_ball_point(points[number], 0.85 * wanted[number])] = False
    return points[chosen]


def _within(points: np.ndarray, hole: np.ndarray) -> np.ndarray:
    """Which points (n, 3) lie, seen from the front, inside a ring (k, 3) of the face."""
    ring = hole[:, :2]
    if ring[0, 0] == 0:  # half a mouth: close it over the midline
        ring = np.concatenate([ring, ring[::-1] * [-1, 1]])
    here, there = ring, np.roll(ring, -1, axis=0)  # the ring's edges
    x, y = points[:, :1], points[:, 1:2]
    spans = (here[:, 1] > y) != (there[:, 1] > y)  # (n, k)
    rise = np.where(here[:, 1] == there[:, 1], 1, there[:, 1] - here[:, 1])
    crossing = here[:, 0] + (y - here[:, 1]) / rise * (there[:, 0] - here[:, 0])
    return ((spans & (x < crossing)).sum(1) % 2 == 1) & (points[:, 2] > 3)
