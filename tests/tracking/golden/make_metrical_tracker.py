"""What metrical-tracker saves of a head that turns, lifts or tilts, of eyes that look or close.

Its published geometry: FLAME's axes are +x to the subject's left, +y up, +z out of the face; the
head rests in them and a camera goes round it. In a picture, the subject who faces the camera has
their left at the right. So OpenCV's camera (+x right, +y down, +z into the picture) sees, of a face
at rest, left at (1, 0, 0), up at (0, -1, 0) and the nose at (0, 0, -1). A head that turns to its
left takes its nose to the right of the picture; one that lifts takes it up; one that tilts to its
left shoulder takes its crown to the right. opencv.R has these three images as its columns, since
it is for points as columns.

PyTorch3D's camera has +x left, +y up, +z in and is for points as rows: the rows of its matrix are
the same three images with x and y negated. Six numbers are the first two rows of a matrix, as its
matrix_to_rotation_6d takes them.

An eye turns in the head, for points as columns: the columns of its matrix are where it takes the
axes of FLAME, the last is where it looks. flame.eyes holds the left eye, then the right;
flame.eyelids the left, then the right, 1 closed. A mirrored picture is that of the opposite.

Run it in its folder, with torch; it writes metrical_tracker/<name>/checkpoint/00000.frame and on.
"""

from pathlib import Path

import numpy as np
import torch

HERE = Path(__file__).parent / "metrical_tracker"
STEPS = (0.0, 0.075, 0.15, 0.225, 0.3)  # radians; three times as much of an eyelid
RIGHT, UP, NEAR = np.array([1, 0, 0]), np.array([0, -1, 0]), np.array([0, 0, -1])  # of OpenCV
LEFT_OF_FACE, UP_OF_FACE, OUT_OF_FACE = np.eye(3)  # of FLAME


def towards(start, goal, angle):
    return np.cos(angle) * start + np.sin(angle) * goal


def camera(nose=0.0, lift=0.0, crown=0.0):
    """Columns: where the subject's left, the crown and the nose are seen, one angle at a time."""
    out = towards(towards(NEAR, RIGHT, nose), UP, lift)
    up = towards(towards(UP, RIGHT, crown), -NEAR, lift)
    return np.stack([np.cross(up, out), up, out], axis=1)


def eye(left=0.0, up=0.0):
    """Columns: where an eye takes FLAME's axes, one angle at a time."""
    look = towards(towards(OUT_OF_FACE, LEFT_OF_FACE, left), UP_OF_FACE, up)
    top = towards(UP_OF_FACE, -OUT_OF_FACE, up)
    return np.stack([np.cross(top, look), top, look], axis=1)


def six(matrix):
    return matrix[:2].reshape(1, 6)


def frame(number, opencv, looking, lids):
    pytorch3d = (opencv * [[-1], [-1], [1]]).T
    numbers = {
        "flame": {
            "exp": np.zeros((1, 100)),
            "eyes": np.concatenate([six(looking), six(looking)], axis=1),
            "eyelids": np.array([lids]),
            "jaw": six(np.eye(3)),
        },
        "camera": {"R": six(pytorch3d), "t": np.array([[0, 0, 1]])},
        "opencv": {"R": opencv[None], "t": np.array([[0, 0, 1]])},
    }
    rounded = {
        group: {name: np.round(n, 5).astype(np.float32) for name, n in fields.items()}
        for group, fields in numbers.items()
    }
    return rounded | {"img_size": np.array([512, 512]), "frame_id": f"{number:05d}"}


MOTIONS = {
    "turns_left": lambda a: (camera(nose=a), eye(), (0, 0)),
    "turns_right": lambda a: (camera(nose=-a), eye(), (0, 0)),
    "lifts_head": lambda a: (camera(lift=a), eye(), (0, 0)),
    "tilts_left": lambda a: (camera(crown=a), eye(), (0, 0)),
    "tilts_right": lambda a: (camera(crown=-a), eye(), (0, 0)),
    "looks_left": lambda a: (camera(), eye(left=a), (0, 0)),
    "looks_right": lambda a: (camera(), eye(left=-a), (0, 0)),
    "looks_up": lambda a: (camera(), eye(up=a), (0, 0)),
    "closes_left_eye": lambda a: (camera(), eye(), (3 * a, 0)),
    "closes_right_eye": lambda a: (camera(), eye(), (0, 3 * a)),
}

if __name__ == "__main__":
    for name, motion in MOTIONS.items():
        folder = HERE / name / "checkpoint"
        folder.mkdir(parents=True, exist_ok=True)
        for number, step in enumerate(STEPS):
            torch.save(frame(number, *motion(step)), folder / f"{number:05d}.frame")
