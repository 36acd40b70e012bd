"""FLAME (Li et al. 2017) from the user's own file: npz, or the pickle as it is published.

The model is not free to copy: nothing of it is here. Its published arrays are v_template (V, 3),
shapedirs (V, 3, 400: 300 of identity, then 100 of expression), posedirs (V, 3, 36), J_regressor
(5, V), weights (V, 5), kintree_table (2, 5), f (F, 3); metres, +Y up, +Z out of the face.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from mimeline.errors import BadFile
from mimeline.face.formats import eyes
from mimeline.face.model import SKIN, Face, Joint

REQUIRED = ("v_template", "shapedirs", "posedirs", "J_regressor", "weights", "kintree_table", "f")
JOINT_NAMES = ("head", "neck", "jaw", "left_eye", "right_eye")  # the first turns the whole model
PARENTS = (None, 0, 1, 1, 1)
N_IDENTITIES = 300
FORWARD = np.float32([0, 0, 1])


def from_arrays(path: Path, arrays: Mapping[str, np.ndarray]) -> Face:
    """The face of FLAME's published arrays: identities shape000..., shapes exp000....

    Raises BadFile where an array is missing or of another shape, or the joints are not FLAME's;
    ValueError as Face does.
    """
    remedy = "Give generic_model.pkl of FLAME 2020, or an npz of the same arrays."
    missing = [name for name in REQUIRED if not isinstance(arrays.get(name), np.ndarray)]
    if missing:
        found, expected = f"no array {', '.join(missing)}", f"arrays {', '.join(REQUIRED)}"
        raise BadFile(path, found=found, expected=expected, remedy=remedy)
    V, J = len(arrays["v_template"]), len(JOINT_NAMES)
    n_shapes = arrays["shapedirs"].shape[-1] if arrays["shapedirs"].ndim else 0
    fitting = {
        "v_template": (V, 3),
        "shapedirs": (V, 3, n_shapes),
        "posedirs": (V, 3, 9 * (J - 1)),
        "J_regressor": (J, V),
        "weights": (V, J),
        "kintree_table": (2, J),
        "f": (len(arrays["f"]) if arrays["f"].ndim else 0, 3),
    }
    for name, shape in fitting.items():
        if arrays[name].shape != shape or arrays[name].dtype.kind not in "iuf":
            raise BadFile(
                path,
                place=f"array {name}",
                found=f"shape {arrays[name].shape} of {arrays[name].dtype}",
                expected=f"numbers of shape {shape}",
                remedy=remedy,
            )
    parents = tuple(arrays["kintree_table"][0].astype(np.int64)[1:].tolist())
    if n_shapes <= N_IDENTITIES or parents != PARENTS[1:]:
        raise BadFile(
            path,
            found=f"{n_shapes} shapes, joints with parents {parents}",
            expected=f"more than {N_IDENTITIES} shapes, joints with parents {PARENTS[1:]}",
            remedy=remedy,
        )
    return _assembled(arrays)


def _assembled(arrays: Mapping[str, np.ndarray]) -> Face:
    neutral = np.float32(arrays["v_template"])
    centres = np.float32(arrays["J_regressor"]) @ neutral  # (J, 3)
    directions = np.float32(arrays["shapedirs"]).transpose(2, 0, 1)  # (300 + expressions, V, 3)
    skin = np.float32(arrays["weights"])
    colours = np.tile(np.uint8(SKIN), (len(neutral), 1))
    for name in ("left_eye", "right_eye"):
        ball = np.flatnonzero(skin[:, JOINT_NAMES.index(name)] > 0.99)
        if len(ball):
            eyes.paint(colours, neutral, ball, FORWARD)
    rows = zip(JOINT_NAMES, PARENTS, centres, strict=True)
    n_expressions = len(directions) - N_IDENTITIES
    return Face(
        neutral=neutral,
        triangles=arrays["f"].astype(np.int64),
        shapes=directions[N_IDENTITIES:],
        shape_names=[f"exp{number:03d}" for number in range(n_expressions)],
        joints=[Joint(*row) for row in rows],
        skin=skin,
        colours=colours,
        identities=directions[:N_IDENTITIES],
        identity_names=[f"shape{number:03d}" for number in range(N_IDENTITIES)],
        pose_shapes=arrays["posedirs"].transpose(2, 0, 1),
        regressor=arrays["J_regressor"],
    )
