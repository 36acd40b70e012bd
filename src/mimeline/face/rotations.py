"""Rotation matrices from angles that are named by what the subject does.

Subject's frame: +X is the subject's left, +Y up, +Z forward; radians; matrices turn column vectors.
"""

import numpy as np


def turned(yaw_left: np.ndarray, pitch_up: np.ndarray, tilt_left: np.ndarray) -> np.ndarray:
    """Rotations (n, 3, 3) float32 of a head that turns, then lifts, then tilts about its own axes.

    yaw_left, pitch_up, tilt_left: (n,) radians, positive as named; tilt_left is towards the
    subject's left shoulder. R = Ry(yaw_left) Rx(-pitch_up) Rz(-tilt_left).
    """
    turn = (
        _about(1, yaw_left) @ _about(0, np.negative(pitch_up)) @ _about(2, np.negative(tilt_left))
    )
    return turn.astype(np.float32)


def angles_of(rotations: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """yaw_left, pitch_up and tilt_left, (n,) radians each, of rotations (n, 3, 3); undoes `turned`.

    pitch_up is within a quarter turn. Rotations are of the subject's frame.
    """
    R = np.asarray(rotations, np.float64)
    pitch_up = np.arcsin(np.clip(R[:, 1, 2], -1, 1))
    yaw_left = np.arctan2(R[:, 0, 2], R[:, 2, 2])
    tilt_left = -np.arctan2(R[:, 1, 0], R[:, 1, 1])
    return yaw_left, pitch_up, tilt_left


def _about(axis: int, angle: np.ndarray) -> np.ndarray:
    """Right-handed rotations (n, 3, 3) about an axis of the frame."""
    angle = np.asarray(angle, np.float64)
    cosine, sine = np.cos(angle), np.sin(angle)
    after, last = (axis + 1) % 3, (axis + 2) % 3
    matrices = np.zeros((len(angle), 3, 3))
    matrices[:, axis, axis] = 1
    matrices[:, after, after] = matrices[:, last, last] = cosine
    matrices[:, after, last], matrices[:, last, after] = -sine, sine
    return matrices
