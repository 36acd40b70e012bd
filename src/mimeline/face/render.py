"""Pictures of a face: a software rasteriser with a z-buffer, soft light and smooth edges.

A pixel is the mean of 2 x 2 samples in linear light, encoded to sRGB. Light falls on interpolated
normals. Within a triangle, normals and colours are interpolated in the picture's plane: triangles
are small against their distance.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from mimeline.face import raster
from mimeline.face.model import Face

BACKGROUND = (232, 234, 238)
MARGIN = 1.25  # of the head's extent
HELD = 0.3  # weight of what counts as head: less is neck and shoulders
DISTANCE = 5.0  # of the camera, in half extents of the head: a portrait lens
NEAR = 0.05  # metres

# Lights in the camera's frame (+X right, +Y up, +Z towards the camera): direction, linear colour.
KEY, KEY_COLOUR = (-0.50, 0.62, 0.75), (0.80, 0.77, 0.72)
FILL, FILL_COLOUR = (0.75, 0.10, 0.55), (0.20, 0.22, 0.26)
SKY_COLOUR, GROUND_COLOUR = (0.30, 0.31, 0.33), (0.13, 0.11, 0.10)
RIM = 0.10
CATCHLIGHT = 3.0  # how bright the key light mirrors in a wholly glossy surface
CORNEA = 2.4  # how far it mirrors towards the camera: an eye bulges where it is looked into
WRAP = (0.28, 0.14, 0.10)  # how far light reaches round an edge: red goes deepest into skin
INSIDE = 0.08  # of the light where a surface is seen from its inner side


@dataclass(frozen=True)
class Camera:
    """A pinhole in front of the face, looking along -Z with +Y up.

    position (3,) metres · focal: pixels · size: edge of the square picture, pixels.
    """

    position: tuple[float, float, float]
    focal: float
    size: int

    @classmethod
    def framing(cls, face: Face, size: int) -> "Camera":
        """The camera that shows the whole head of the neutral face, with room to turn it."""
        (x, y, middle), half = extent(face)
        z = middle + DISTANCE * half
        return cls((x, y, z), size / 2 * (z - middle) / half, size)

    def project(self, points: np.ndarray) -> np.ndarray:
        """Pixel (column, row) of points (..., 3); a pixel's centre is at its number + 0.5."""
        return self._seen(np.asarray(points, np.float32))[..., :2]

    def _seen(self, points: np.ndarray) -> np.ndarray:
        """(..., 3) of points (..., 3): column, row and 1 / distance, 0 behind the camera."""
        away = points - np.float32(self.position)
        distance = -away[..., 2]
        near = distance > NEAR
        nearness = np.where(near, 1 / np.where(near, distance, 1), 0)
        half = self.size / 2
        with np.errstate(over="ignore", invalid="ignore"):  # such points are not drawn
            offset = away[..., :2] * (self.focal * nearness)[..., None]
        seen = [half + offset[..., 0], half - offset[..., 1], nearness]
        return np.stack(seen, axis=-1).astype(np.float32)


def draw(
    face: Face,
    vertices: np.ndarray,
    camera: Camera,
    background: tuple[int, int, int] = BACKGROUND,
) -> np.ndarray:
    """A picture (size, size, 3) uint8 sRGB of the face's mesh at vertices (V, 3), metres.

    Raises ValueError where the vertices are not the face's.
    """
    if vertices.shape != face.neutral.shape:
        raise ValueError(f"vertices have shape {vertices.shape}, expected {face.neutral.shape}")
    vertices = np.ascontiguousarray(vertices, np.float32)
    edge = 2 * camera.size  # samples
    nearest = np.zeros((edge, edge), np.float32)
    owner = np.full((edge, edge), -1, np.int32)
    seen = camera._seen(vertices) * np.float32([2, 2, 1])  # (V, 3), in samples
    raster.cover(seen, face.triangles, nearest, owner)
    normals = raster.vertex_normals(vertices, face.triangles)  # (V, 3)
    looks = [LINEAR[face.colours], face.gloss[:, None]]
    corners = np.concatenate([seen[:, :2], normals, *looks], axis=1)  # (V, 9)
    picture = np.empty((camera.size, camera.size, 3), np.uint8)
    ground = LINEAR[np.uint8(background)]
    raster.shade(corners, face.triangles, owner, LIGHTS, ground, ENCODED, picture)
    return picture


def film(
    face: Face,
    vertices: np.ndarray,
    camera: Camera,
    background: tuple[int, int, int] = BACKGROUND,
) -> Iterator[np.ndarray]:
    """One picture per frame of vertices (n, V, 3), made as it is asked for."""
    for frame in vertices:
        yield draw(face, frame, camera, background)


def strip(pictures: Sequence[np.ndarray]) -> np.ndarray:
    """Pictures of one height side by side, as one (H, sum of W, 3) array."""
    return np.concatenate(list(pictures), axis=1)


def extent(face: Face) -> tuple[tuple[float, float, float], float]:
    """Where the neutral head is, metres: its middle, and half of what a picture of it spans."""
    head = face.neutral[_head_weight(face) > HELD]
    low, high = head.min(0).astype(float), head.max(0).astype(float)
    half = MARGIN * max(high[0] - low[0], high[1] - low[1]) / 2
    return tuple(((low + high) / 2).tolist()), float(half)


def _head_weight(face: Face) -> np.ndarray:
    """How much of each vertex (V,) the head carries, with all that hangs on it."""
    carried: list[bool] = []
    for joint in face.joints:
        on_it = joint.parent is not None and carried[joint.parent]
        carried.append(joint.name == "head" or on_it)
    return face.skin[:, carried].sum(1) if any(carried) else np.ones(len(face.neutral))


def _linear(encoded: np.ndarray) -> np.ndarray:
    """Linear light of sRGB values in [0, 1] (IEC 61966-2-1)."""
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def _encoded(linear: np.ndarray) -> np.ndarray:
    """sRGB values in [0, 1] of linear light (IEC 61966-2-1)."""
    return np.where(linear <= 0.0031308, linear * 12.92, 1.055 * linear ** (1 / 2.4) - 0.055)


def _unit(vector: Sequence[float]) -> np.ndarray:
    return np.divide(vector, np.linalg.norm(vector))


LINEAR = _linear(np.arange(256) / 255).astype(np.float32)
ENCODED = np.rint(255 * _encoded(np.linspace(0, 1, 4096))).astype(np.uint8)
LIGHTS = np.float32(
    [
        _unit(KEY),
        KEY_COLOUR,
        _unit(FILL),
        FILL_COLOUR,
        SKY_COLOUR,
        GROUND_COLOUR,
        WRAP,
        _unit(np.add(_unit(KEY), (0, 0, 1))),
        (RIM, CATCHLIGHT, INSIDE),
        np.divide(1, np.add(1, WRAP)),
        _unit(np.add(_unit(KEY), (0, 0, CORNEA))),
    ]
)
