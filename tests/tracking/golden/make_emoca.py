"""What EMOCA's codes are of a head that turns, lifts and tilts.

The published projection (EMOCA's and DECA's): FLAME's vertices, rotated by the root, are scaled and
shifted, then y and z change sign, which gives the picture's axes (x right, y down, z into it). A
point is therefore further to the right of the picture the larger its x, further up the larger its
y, and nearer to the camera the larger its z: the camera looks along -z at a face that, unrotated,
looks at it. A subject who faces the camera has their left at the right of the picture.

So to turn to the left is to take the nose from (0, 0, 1) to the right of the picture; to lift is to
take it up; to tilt to the left shoulder is to take the crown from (0, 1, 0) to the right. PICTURE
below checks each against the projection. pose.npy is the root's axis times angle, then the jaw's.
Folders are numbered from 1, with the number of the face behind, as the authors' code names what it
unpacks a video into. A mirrored picture is that of the opposite turn.

Run it in its folder; it writes emoca/<name>/<frame>_000/{exp,pose}.npy.
"""

from pathlib import Path

import numpy as np
from make_flame import HEADS, STEPS, logarithm

HERE = Path(__file__).parent / "emoca"
NOSE, CROWN = np.array([0, 0, 1.0]), np.array([0, 1.0, 0])
PICTURE = {  # what moves, and where it goes in the picture: along x (right) or y (down)
    "turns_left": (NOSE, 0, 1),
    "turns_right": (NOSE, 0, -1),
    "lifts_head": (NOSE, 1, -1),
    "tilts_left": (CROWN, 0, 1),
    "tilts_right": (CROWN, 0, -1),
}


def projected(point, scale=8.0, shift=(0.01, 0.02)):
    x, y, z = scale * (point + np.array([*shift, 0]))
    return np.array([x, -y, -z])


if __name__ == "__main__":
    for name, (move, sign) in HEADS.items():
        point, axis, way = PICTURE[name]
        moved = projected(move(sign * STEPS[-1]) @ point) - projected(point)
        assert np.sign(moved[axis]) == way
        for number, step in enumerate(STEPS, start=1):
            folder = HERE / name / f"{number:06d}_000"
            folder.mkdir(parents=True, exist_ok=True)
            pose = np.zeros(6, np.float32)
            pose[:3] = np.round(logarithm(move(sign * step)), 4)
            np.save(folder / "exp.npy", np.zeros(50, np.float32))
            np.save(folder / "pose.npy", pose)
