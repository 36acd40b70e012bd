"""Golden OpenFace 2 tables, from the geometry that OpenFace publishes.

The camera's axes are +X right in the picture, +Y down, +Z away from the camera. A subject who faces
the camera has the nose along -Z, the top of the head along -Y and the own left along +X, which is
the right of an unmirrored picture. A pose takes that rest to the head as it is held, so its matrix
has the turned left, down and back as columns. OpenFace's rotation helpers write it as
R = Rx Ry Rz with

    R[0, 2] = sin y     R[1, 2] = -cos y sin x     R[0, 1] = -cos y sin z

and the other sines and cosines to match, which is solved for the three angles. Gaze vectors are
directions in the same axes, so that eyes which rest in a turned head look where the nose points;
gaze_angle_x and _y are atan2(x, -z) and atan2(y, -z) of their mean.
"""

from pathlib import Path

import numpy as np

UNITS = (1, 2, 4, 5, 6, 7, 9, 10, 12, 14, 15, 17, 20, 23, 25, 26, 45)
LARGEST = 0.3  # radians
VERGENCE = 0.05  # each eye turns that far towards the nose, to meet the other near the camera
LEFT, DOWN, BACK = np.eye(3)


def between(start, end, angle):
    """The direction that leaves `start` towards `end` by an angle."""
    return np.cos(angle) * start + np.sin(angle) * end


def pose(move, angle):
    """The head's matrix: its own left, down and back, in the camera's axes."""
    left, down, back = LEFT, DOWN, BACK
    if move in ("turns_left", "turns_right"):
        side = LEFT if move == "turns_left" else -LEFT
        back = -between(-BACK, side, angle)  # the nose goes to the side
        left = np.cross(down, back)
    elif move == "lifts_head":
        back = -between(-BACK, -DOWN, angle)  # the nose goes up
        down = np.cross(back, left)
    elif move in ("tilts_left", "tilts_right"):
        side = LEFT if move == "tilts_left" else -LEFT
        down = -between(-DOWN, side, angle)  # the top of the head goes to the shoulder
        left = np.cross(down, back)
    return np.stack([left, down, back], axis=1)


def angles(R):
    return (
        np.arctan2(-R[1, 2], R[2, 2]),
        np.arctan2(R[0, 2], np.hypot(R[0, 0], R[0, 1])),
        np.arctan2(-R[0, 1], R[0, 0]),
    )


def gazes(move, angle):
    """Directions of eye 0, leftmost in the picture, and eye 1, as if the head were at rest."""
    sideways = {"looks_left": angle, "looks_right": -angle}.get(move, 0.0)
    upwards = angle if move == "looks_up" else 0.0
    eyes = []
    for inwards in (VERGENCE, -VERGENCE):  # eye 0 turns to the picture's right to meet eye 1
        flat = between(-BACK, LEFT, sideways + inwards)
        eyes.append(between(flat, -DOWN, upwards))
    return eyes


def row(number, move, angle):
    eyes = [pose(move, angle) @ gaze for gaze in gazes(move, angle)]
    mean = sum(eyes) / 2
    told = [number, 0, (number - 1) / 30, 0.98, 1]
    told += [*eyes[0], *eyes[1], np.arctan2(mean[0], -mean[2]), np.arctan2(mean[1], -mean[2])]
    told += [0.0, 0.0, 600.0, *angles(pose(move, angle))]
    told += [0.1] * len(UNITS) + [0] * (len(UNITS) + 1)
    return ", ".join(f"{value + 0.0:.6g}" for value in told)


def header():
    names = ["frame", "face_id", "timestamp", "confidence", "success"]
    names += [f"gaze_{eye}_{axis}" for eye in (0, 1) for axis in "xyz"]
    names += ["gaze_angle_x", "gaze_angle_y"]
    names += [f"pose_{kind}{axis}" for kind in "TR" for axis in "xyz"]
    names += [f"AU{unit:02d}_r" for unit in UNITS]
    names += [f"AU{unit:02d}_c" for unit in sorted((*UNITS, 28))]
    return ", ".join(names)


MOVES = ("turns_left", "turns_right", "lifts_head", "tilts_left", "tilts_right")
MOVES += ("looks_left", "looks_right", "looks_up")

if __name__ == "__main__":
    for move in MOVES:
        rows = [row(1 + step, move, LARGEST * step / 4) for step in range(5)]
        path = Path(__file__).parent / "openface" / f"{move}.csv"
        path.write_text("\n".join([header(), *rows]) + "\n")
