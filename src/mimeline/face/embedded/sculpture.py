"""The skin of the embedded face as an implicit surface: where a ray meets it.

Centimetres; +X the subject's left, +Y up, +Z forward; y = 0 at the pupils, z = 0 amid the skull.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import RBFInterpolator

from mimeline.face.embedded.anatomy import EYE, EYE_RADIUS, HEAD_POINTS, LID_THICKNESS
from mimeline.face.falloff import folded

CENTRE = np.array([0.0, -3.0, -0.5])  # every ray from here meets the head once
FARTHEST = 20.0  # no part of the head lies farther from the centre


@dataclass(frozen=True)
class Capsule:
    """A rod with round ends of two radii, melted into what is there over `melt`."""

    start: tuple[float, float, float]
    end: tuple[float, float, float]
    start_radius: float
    end_radius: float
    melt: float

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Roughly the distance of points (..., 3) from the surface, negative inside."""
        start, end = np.asarray(self.start), np.asarray(self.end)
        along = end - start
        length2 = max(along @ along, 1e-9)
        share = np.clip((points - start) @ along / length2, 0, 1)
        off = points - start - share[..., None] * along
        radius = self.start_radius + share * (self.end_radius - self.start_radius)
        return np.sqrt((off * off).sum(-1)) - radius


# The nose; the wing stands for both.
NOSE = (
    Capsule((0, 0.9, 8.4), (0, -3.2, 10.3), 0.5, 0.7, 1.5),  # bridge
    Capsule((0, -3.4, 10.4), (0, -3.5, 10.45), 0.8, 0.8, 0.8),  # tip
    Capsule((0.85, -3.95, 9.7), (1.15, -4.05, 9.1), 0.55, 0.55, 0.5),  # wing
    Capsule((0, -4.1, 10.3), (0, -4.7, 9.6), 0.35, 0.35, 0.6),  # septum
)
LIDS = (Capsule(EYE, EYE, EYE_RADIUS + LID_THICKNESS, EYE_RADIUS + LID_THICKNESS, 0.35),)


def directions(points: np.ndarray, origin: np.ndarray = CENTRE) -> np.ndarray:
    """Unit directions (..., 3) from an origin (3,) to points (..., 3)."""
    off = points - origin
    return off / np.linalg.norm(off, axis=-1, keepdims=True)


class Skin:
    """The bald head: a thin plate through anatomy's points, with nose and eyelids melted on."""

    def __init__(self, with_lids: bool = True):
        self.details = NOSE + LIDS if with_lids else NOSE

    @cached_property
    def _plate(self) -> RBFInterpolator:
        half = np.array(HEAD_POINTS)
        side = half[half[:, 0] > 0]
        points = np.concatenate([half, side * [-1, 1, 1]]) - CENTRE
        radii = np.linalg.norm(points, axis=1)
        return RBFInterpolator(
            points / radii[:, None], radii, kernel="cubic", degree=1, smoothing=2e-4
        )

    def head_radius(self, directions: np.ndarray) -> np.ndarray:
        """Distance (n,) of the head without nose and lids from CENTRE in unit directions (n, 3)."""
        return self._plate(directions)

    def _melted(self, distance: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Distances (n,) of points (n, 3) from the head, with the details melted on.

        The smooth minimum is Quilez's quadratic one: it bulges where two surfaces meet.
        """
        left = folded(points)
        for detail in self.details:
            other, melt = detail.distance(left), detail.melt
            overlap = np.maximum(melt - np.abs(distance - other), 0) / melt
            distance = np.minimum(distance, other) - overlap**2 * melt / 4
        return distance

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Roughly how far points (n, 3) lie outside of the skin, negative inside."""
        off = points - CENTRE
        radii = np.linalg.norm(off, axis=1)
        return self._melted(radii - self.head_radius(off / radii[:, None]), points)

    def radial(self, directions: np.ndarray) -> np.ndarray:
        """Where rays from CENTRE in unit directions (n, 3) leave the skin: points (n, 3)."""
        head = self.head_radius(directions)
        low, high = head - 0.5, head + 4.0
        for _ in range(15):
            middle = (low + high) / 2
            points = CENTRE + middle[:, None] * directions
            inside = self._melted(middle - head, points) < 0
            low, high = np.where(inside, middle, low), np.where(inside, high, middle)
        return CENTRE + low[:, None] * directions

    def cast(self, origin: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Where rays from a point (3,) inside in unit directions (n, 3) leave the skin: (n, 3)."""
        low, high = np.zeros(len(directions)), np.full(len(directions), FARTHEST)
        for _ in range(18):
            middle = (low + high) / 2
            inside = self.distance(origin + middle[:, None] * directions) < 0
            low, high = np.where(inside, middle, low), np.where(inside, high, middle)
        return origin + low[:, None] * directions

    def frontal(self, across: np.ndarray, up: np.ndarray) -> np.ndarray:
        """Points (n, 3) of the skin at x = across and y = up (n,), seen from the front."""
        points = np.stack([across, up, np.full_like(across, 8.0)], axis=-1)
        for _ in range(10):
            points[:, 2] -= np.clip(self.distance(points), -1, 1)
        return points
