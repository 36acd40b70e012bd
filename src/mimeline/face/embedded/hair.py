"""The hair of the embedded face: where it begins and how thick it lies on the skin.

Centimetres, frame of anatomy.
"""

from functools import cache

import numpy as np
from scipy.interpolate import PchipInterpolator

from mimeline.face.embedded.anatomy import HAIR_AXIS, HAIR_CENTRE, HAIRLINE
from mimeline.face.embedded.sculpture import Skin, directions
from mimeline.face.falloff import bell

COLUMNS = 48  # of vertices along the hairline, from forehead to nape
HALF_BORDER = 0.014  # radians, from the hairline to the rows of vertices on either side

CENTRE, AXIS = np.array(HAIR_CENTRE), np.array(HAIR_AXIS)
FORWARD = np.array([0, -AXIS[2], AXIS[1]])  # square to the axis


def depth_inside(points: np.ndarray) -> np.ndarray:
    """How far (n,) points (n, 3) lie inside the hairline along the skin; negative outside."""
    azimuth, polar = _angles(points)
    return (_hairline()(azimuth) - polar) * np.linalg.norm(points - CENTRE, axis=1)


def raised(points: np.ndarray, depth: np.ndarray) -> np.ndarray:
    """Points (n, 3) of the skin, lifted by the hair where depth (n,) says that there is some."""
    crown = 0.5 + 0.6 * np.clip((points[:, 1] + 3) / 11, 0, 1)
    quiff = 0.5 * bell(points, (0, 8, 6.2), (3.8, 2.6, 3))
    cropped = 1 - 0.75 * bell(points, (7.2, 1.0, -0.3), (3, 3.0, 3.2))  # over the ear
    full = (0.95 * crown * cropped + quiff) * (1 - np.exp(-np.maximum(depth, 0) / 0.9))
    thickness = np.where(depth > 0, 0.16 + full, 0)
    return points + thickness[:, None] * directions(points, CENTRE)


def hairline_rows(skin: Skin) -> np.ndarray:
    """Two rows of points (2 COLUMNS, 3) along the left hairline: on bare skin, and in the hair."""
    line = _hairline()
    azimuth = np.linspace(0, np.pi, 600)
    unrolled = np.stack([azimuth * np.sin(line(azimuth)), line(azimuth)], axis=-1)  # (600, 2)
    walked = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(unrolled, axis=0), axis=1))])
    azimuth = np.interp(np.linspace(0, walked[-1], COLUMNS), walked, azimuth)
    polar, slope = line(azimuth), line(azimuth, 1) / np.sin(line(azimuth))
    rows = []
    for off in (-HALF_BORDER, HALF_BORDER):  # square to the line
        turn = azimuth + off * slope / np.hypot(slope, 1) / np.sin(polar)
        fall = polar - off / np.hypot(slope, 1)
        around = np.cos(turn)[:, None] * FORWARD + np.sin(turn)[:, None] * [1, 0, 0]
        row = skin.cast(CENTRE, np.cos(fall)[:, None] * AXIS + np.sin(fall)[:, None] * around)
        row[[0, -1], 0] = 0
        rows.append(row)
    return np.concatenate(rows)


@cache
def _hairline() -> PchipInterpolator:
    """The hairline's angle from the axis at an azimuth in [0 forward, pi back]."""
    return PchipInterpolator(*_angles(np.array(HAIRLINE, float)))


def _angles(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Azimuth and angle from the hair's axis (n,) of points (n, 3), radians."""
    rays = directions(points, CENTRE)
    azimuth = np.arctan2(np.abs(rays[:, 0]), rays @ FORWARD)
    return azimuth, np.arccos(np.clip(rays @ AXIS, -1, 1))
