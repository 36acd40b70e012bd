"""Colours of an eyeball, so that its gaze can be seen."""

import numpy as np

PUPIL, IRIS, LIMBUS, SCLERA = (14, 12, 12), (92, 118, 128), (48, 42, 40), (232, 228, 224)
RINGS = (  # where a colour lies, off the gaze, in radii of the ball; blended between
    (0.12, PUPIL),
    (0.17, IRIS),
    (0.34, IRIS),
    (0.39, LIMBUS),
    (0.45, SCLERA),
)


def centre_of(points: np.ndarray) -> np.ndarray:
    """The middle (3,) of a ball's vertices (n, 3), which may lie denser in front."""
    return (points.min(0) + points.max(0)) / 2


def paint(colours: np.ndarray, neutral: np.ndarray, ball: np.ndarray, gaze: np.ndarray) -> None:
    """Colour the vertices of an eyeball in place: pupil, iris, its dark border, white.

    colours (V, 3) uint8 · neutral (V, 3) · ball: numbers of its vertices · gaze (3,): unit vector
    from the ball's centre through the pupil.
    """
    points = neutral[ball] - centre_of(neutral[ball])  # (n, 3)
    off = np.linalg.norm(np.cross(points, gaze), axis=1)  # (n,)
    off /= max(np.linalg.norm(points, axis=1).max(), np.finfo(np.float32).tiny)  # a lone vertex
    off[points @ gaze < 0] = 1
    edges, shades = zip(*RINGS, strict=True)
    painted = [np.interp(off, edges, channel) for channel in zip(*shades, strict=True)]
    colours[ball] = np.rint(np.stack(painted, axis=1))
