"""What Deep3DFaceReconstruction says of a head that turns, lifts and tilts.

Its published geometry: a vertex v, a row, stands at v @ transpose(Rz Ry Rx) + t; the camera is at
z = 10 and looks along -z (depth = 10 - z), and the projection's y is opposite to the picture's
rows. So x is to the right of the picture, y up, z towards the camera, and at rest the face looks
along +z. A subject who faces the camera has their left at the right of the picture.

A head that turns to its left takes its nose from (0, 0, 1) to the right of the picture; one that
lifts takes it up; one that tilts to the left shoulder takes its crown from (0, 1, 0) to the right.
Each is written as a matrix with these images, then taken apart in the published order: of
R = Rz Ry Rx, angle_x = atan2(R21, R22), angle_y = asin(-R20), angle_z = atan2(R10, R00). A mirrored
picture is that of the opposite turn.

Run it in its folder; it writes bfm/<name>.mat.
"""

from pathlib import Path

import numpy as np
from scipy.io import savemat

HERE = Path(__file__).parent / "bfm"
STEPS = (0.0, 0.075, 0.15, 0.225, 0.3)  # radians


def nose_right(angle):
    """Columns: where the right of the picture, the crown and the nose go."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]).T


def nose_up(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]]).T


def crown_right(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T


def angles(R):
    return np.arctan2(R[2, 1], R[2, 2]), np.arcsin(-R[2, 0]), np.arctan2(R[1, 0], R[0, 0])


MOTIONS = {
    "turns_left": (nose_right, 1),
    "turns_right": (nose_right, -1),
    "lifts_head": (nose_up, 1),
    "tilts_left": (crown_right, 1),
    "tilts_right": (crown_right, -1),
}

if __name__ == "__main__":
    identity = np.round(np.sin(np.arange(80)), 2)
    for name, (move, sign) in MOTIONS.items():
        coeff = np.zeros((len(STEPS), 257), np.float32)
        coeff[:, :80] = identity
        coeff[:, 224:227] = [np.round(angles(move(sign * step)), 4) for step in STEPS]
        path = HERE / f"{name}.mat"
        savemat(path, {"coeff": coeff}, do_compression=True)
        text = b"MATLAB 5.0 MAT-file".ljust(116)  # in place of the date, so that nothing changes
        path.write_bytes(text + path.read_bytes()[116:])
