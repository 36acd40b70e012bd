"""The Basel Face Model as Deep3DFaceReconstruction packs it, from the user's own file.

The model is not free to copy: nothing of it is here. BFM_model_front.mat holds meanshape (3 V),
idBase (3 V, 80), exBase (3 V, 64), meantex (3 V, 0-255), tri (F, 3) and keypoints (68,), the last
two counted from 1; decimetres; +X the subject's left, +Y up, +Z out of the face. A point's three
numbers stand together. Deng et al. 2019 take its mean as the origin, and so does this.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from mimeline.errors import BadFile
from mimeline.face.fitting import fitted, vertex_numbers
from mimeline.face.formats.shapes import head_only, metres_per_unit
from mimeline.face.model import Face

REQUIRED = ("meanshape", "idBase", "exBase", "tri", "keypoints")
ARRAYS = (*REQUIRED, "meantex")
REMEDY = "Give BFM_model_front.mat as Deep3DFaceReconstruction's preparation writes it."


def from_arrays(path: Path, arrays: Mapping[str, np.ndarray]) -> Face:
    """The face of BFM_model_front.mat's arrays: identities shape000..., shapes exp000....

    Raises BadFile where an array is missing, no unit makes it a head or it does not look along +Z,
    Unfit where an array is of another type or shape, and as Face does.
    """
    missing = [name for name in REQUIRED if name not in arrays]
    if missing:
        found, expected = f"no array {', '.join(missing)}", f"arrays {', '.join(REQUIRED)}"
        raise BadFile(path, found=found, expected=expected, remedy=REMEDY)
    flat = np.asarray(arrays["meanshape"]).reshape(-1)
    V = len(flat) // 3
    neutral = fitted("meanshape", flat, np.float32, (3 * V,)).reshape(V, 3)
    unit = metres_per_unit(path, neutral)
    people = fitted("idBase", arrays["idBase"], np.float32, (3 * V, None))
    expressions = fitted("exBase", arrays["exBase"], np.float32, (3 * V, None))
    triangles = vertex_numbers("tri", _from_0(arrays["tri"]), np.int32, (None, 3), V)
    points = _from_0(arrays["keypoints"]).reshape(-1)
    landmarks = vertex_numbers("keypoints", points, np.int64, (68,), V)
    _refuse_turned(path, neutral[landmarks])
    neutral = (neutral - neutral.mean(0)) * unit
    joints, skin = head_only(neutral)
    return Face(
        neutral=neutral,
        triangles=_outwards(triangles, neutral),
        shapes=expressions.T.reshape(-1, V, 3) * unit,
        shape_names=[f"exp{number:03d}" for number in range(expressions.shape[1])],
        joints=joints,
        skin=skin,
        colours=_colours(arrays, V),
        identities=people.T.reshape(-1, V, 3) * unit,
        identity_names=[f"shape{number:03d}" for number in range(people.shape[1])],
        landmarks=landmarks,
    )


def _from_0(numbers: np.ndarray) -> np.ndarray:
    """Numbers that were counted from 1."""
    return np.asarray(numbers, np.float64) - 1


def _colours(arrays: Mapping[str, np.ndarray], V: int) -> np.ndarray | None:
    if "meantex" not in arrays:
        return None
    texture = fitted("meantex", np.asarray(arrays["meantex"]).reshape(-1), np.float32, (3 * V,))
    return np.rint(texture.clip(0, 255)).astype(np.uint8).reshape(V, 3)


def _outwards(triangles: np.ndarray, neutral: np.ndarray) -> np.ndarray:
    """Triangles counter-clockwise seen from outside; those of an open face that looks along +Z."""
    a, b, c = (neutral[triangles[:, k]] for k in range(3))
    seen = np.cross(b - a, c - a)[:, 2].sum() > 0
    return triangles if seen else np.ascontiguousarray(triangles[:, ::-1])


def _refuse_turned(path: Path, landmarks: np.ndarray) -> None:
    """Raises BadFile where landmarks (68, 3) are not those of an upright face before +Z."""
    right, left, chin, tip = landmarks[[0, 16, 8, 30]]
    between = (landmarks[36] + landmarks[45]) / 2  # the outer corners of the eyes
    if left[0] > right[0] and between[1] > chin[1] and tip[2] > max(right[2], left[2]):
        return
    raise BadFile(
        path,
        place="array keypoints",
        found="a face that is turned or mirrored",
        expected="+x to the subject's left, +y up, +z out of the face; landmarks in iBUG order",
        remedy=REMEDY,
    )
