"""What FLAME's coefficients are of a head that turns, lifts and tilts, of eyes that look and close.

FLAME's template, as published with the model, faces +z with +y up; its left eye, the subject's, is
at positive x. Rotations are axis times angle, and a joint's matrix is applied after its parent's:
a vertex of the head goes by the root's matrix, then within it by the neck's, and an eye within that
by its own. A matrix is written with what it does to nose, crown and left ear, and its axis times
angle is its logarithm: angle = acos((trace - 1) / 2), axis along (R21 - R12, R02 - R20, R10 - R01).

A head that turns to its left takes its nose from (0, 0, 1) towards +x; one that lifts takes it
towards +y; one that tilts to the left shoulder takes its crown from (0, 1, 0) towards +x. Half of
it is told by the root, half by the neck. A gaze to the left, or up, takes an eye's front the same
way. eyelids are the left's and the right's, 1 where closed. A mirrored picture is that of the
opposite motion.

Run it in its folder; it writes flame/<name>.npz.
"""

from pathlib import Path

import numpy as np

HERE = Path(__file__).parent / "flame"
STEPS = (0.0, 0.075, 0.15, 0.225, 0.3)  # radians


def front_left(angle):
    """Columns: where the left, the crown and the front go."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]).T


def front_up(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]]).T


def crown_left(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T


def logarithm(R):
    angle = np.arccos(np.clip((np.trace(R) - 1) / 2, -1, 1))
    axis = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    return axis * (angle / (2 * np.sin(angle)) if angle > 1e-9 else 0.5)


HEADS = {
    "turns_left": (front_left, 1),
    "turns_right": (front_left, -1),
    "lifts_head": (front_up, 1),
    "tilts_left": (crown_left, 1),
    "tilts_right": (crown_left, -1),
}
EYES = {"looks_left": (front_left, 1), "looks_right": (front_left, -1), "looks_up": (front_up, 1)}
LIDS = {"closes_left_eye": 0, "closes_right_eye": 1}


def rest():
    n = len(STEPS)
    widths = {"expression": 50, "global_orient": 3, "neck_pose": 3, "jaw_pose": 3, "eyes_pose": 6}
    return {name: np.zeros((n, width)) for name, width in widths.items()} | {
        "eyelids": np.zeros((n, 2))
    }


def save(name, arrays):
    small = {key: np.round(array, 4).astype(np.float32) for key, array in arrays.items()}
    np.savez_compressed(HERE / f"{name}.npz", **small)


if __name__ == "__main__":
    for name, (move, sign) in HEADS.items():
        arrays = rest()
        half = [logarithm(move(sign * step / 2)) for step in STEPS]
        arrays["global_orient"][:] = arrays["neck_pose"][:] = half
        save(name, arrays)
    for name, (move, sign) in EYES.items():
        arrays = rest()
        arrays["eyes_pose"][:] = [np.tile(logarithm(move(sign * step)), 2) for step in STEPS]
        save(name, arrays)
    for name, lid in LIDS.items():
        arrays = rest()
        arrays["eyelids"][:, lid] = 3 * np.array(STEPS)
        save(name, arrays)
