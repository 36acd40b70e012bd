"""FLAME (Li et al. 2017) from the user's own file: npz, or the pickle as it is published.

The model is not free to copy: nothing of it is here. Its published arrays are v_template (V, 3),
shapedirs (V, 3, 400: 300 of identity, then 100 of expression), posedirs (V, 3, 36), J_regressor
(5, V), weights (V, 5), kintree_table (2, 5), f (F, 3); +Y up, +Z out of the face.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from mimeline.errors import BadFile
from mimeline.face.fitting import fitted, vertex_numbers
from mimeline.face.formats import eyes
from mimeline.face.formats.shapes import metres_per_unit
from mimeline.face.model import SKIN, Face, Joint

REQUIRED = ("v_template", "shapedirs", "posedirs", "J_regressor", "weights", "kintree_table", "f")
JOINT_NAMES = ("head", "neck", "jaw", "left_eye", "right_eye")  # the first turns the whole model
PARENTS = (None, 0, 1, 1, 1)
N_IDENTITIES = 300
FORWARD = np.float32([0, 0, 1])


def from_arrays(path: Path, arrays: Mapping[str, np.ndarray]) -> Face:
    """The face of FLAME's published arrays: identities shape000..., shapes exp000....

    Raises BadFile where an array is missing, the joints are not FLAME's, or no unit makes it a
    head; Unfit where an array is of another type or shape, and as Face does.
    """
    remedy = "Give generic_model.pkl of FLAME 2020, or an npz of the same arrays."
    missing = [name for name in REQUIRED if not isinstance(arrays.get(name), np.ndarray)]
    if missing:
        found, expected = f"no array {', '.join(missing)}", f"arrays {', '.join(REQUIRED)}"
        raise BadFile(path, found=found, expected=expected, remedy=remedy)
    neutral = fitted("v_template", arrays["v_template"], np.float32, (None, 3))
    unit = metres_per_unit(path, neutral)
    V, J = len(neutral), len(JOINT_NAMES)
    directions = fitted("shapedirs", arrays["shapedirs"], np.float32, (V, 3, None))
    pose_shapes = fitted("posedirs", arrays["posedirs"], np.float32, (V, 3, 9 * (J - 1)))
    regressor = fitted("J_regressor", arrays["J_regressor"], np.float32, (J, V))
    skin = fitted("weights", arrays["weights"], np.float32, (V, J))
    triangles = vertex_numbers("f", arrays["f"], np.int32, (None, 3), V)
    tree = fitted("kintree_table", arrays["kintree_table"], np.int64, (2, J))
    n_shapes, parents = directions.shape[-1], tuple(tree[0, 1:].tolist())
    if n_shapes <= N_IDENTITIES or parents != PARENTS[1:]:
        raise BadFile(
            path,
            found=f"{n_shapes} shapes, joints with parents {parents}",
            expected=f"more than {N_IDENTITIES} shapes, joints with parents {PARENTS[1:]}",
            remedy=remedy,
        )
    neutral = neutral * unit
    directions = directions.transpose(2, 0, 1) * unit  # (300 + expressions, V, 3)
    rows = zip(JOINT_NAMES, PARENTS, regressor @ neutral, strict=True)
    n_expressions = n_shapes - N_IDENTITIES
    return Face(
        neutral=neutral,
        triangles=triangles,
        shapes=directions[N_IDENTITIES:],
        shape_names=[f"exp{number:03d}" for number in range(n_expressions)],
        joints=[Joint(*row) for row in rows],
        skin=skin,
        colours=_colours(neutral, skin),
        identities=directions[:N_IDENTITIES],
        identity_names=[f"shape{number:03d}" for number in range(N_IDENTITIES)],
        pose_shapes=pose_shapes.transpose(2, 0, 1) * unit,
        regressor=regressor,
    )


def _colours(neutral: np.ndarray, skin: np.ndarray) -> np.ndarray:
    """Colours (V, 3) of skin, and of the eyeballs that the weights (V, J) tell."""
    colours = np.tile(np.uint8(SKIN), (len(neutral), 1))
    for name in ("left_eye", "right_eye"):
        ball = np.flatnonzero(skin[:, JOINT_NAMES.index(name)] > 0.99)
        if len(ball):
            eyes.paint(colours, neutral, ball, FORWARD)
    return colours
