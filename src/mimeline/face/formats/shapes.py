"""Face models as named arrays: what any model can be brought to, and read back as it was.

An npz file with neutral, triangles, shapes and shape_names; everything else that a Face holds may
stand beside them. The parts that loaders share lie here too: units, sides, a head that turns.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from mimeline.atomic import whole
from mimeline.errors import BadFile
from mimeline.face.fitting import fitted, names_of
from mimeline.face.model import Face, Joint
from mimeline.face.motion import driver
from mimeline.vocabulary import CHANNELS, canonical

REQUIRED = ("neutral", "triangles", "shapes", "shape_names")
JOINTS = ("joint_names", "joint_parents", "joint_centres", "skin")
OPTIONAL = (
    "colours",
    "identities",
    "identity_names",
    "correctives",
    "landmarks",
    "pose_shapes",
    "regressor",
    "gloss",
)
OFFSETS = {  # what stands before (V, 3) in their shapes
    "shapes": (None,),
    "identities": (None,),
    "correctives": (None, None),
    "pose_shapes": (None,),
}
HEAD_HEIGHTS = (0.12, 0.8)  # metres, from a bare face to a bust
UNITS = (1.0, 0.1, 0.01, 0.001)  # metres


def from_arrays(path: Path, arrays: dict[str, np.ndarray]) -> Face:
    """The face of an npz file with named shapes.

    Required: neutral (V, 3), triangles (F, 3), shapes (S, V, 3) offsets, shape_names (S,).
    Optional: what `Face` holds; joints as joint_names, joint_parents (-1: none), joint_centres,
    skin, all or none of them.
    Raises BadFile for a missing or unknown array and an unknown size, Unfit where an array is of
    another type or shape, and as `named` does.
    """
    known = (*REQUIRED, *JOINTS, *OPTIONAL)
    missing = [name for name in REQUIRED if name not in arrays]
    has_joints = [name for name in JOINTS if name in arrays]
    if has_joints and len(has_joints) < len(JOINTS):
        missing += [name for name in JOINTS if name not in arrays]
    unknown = sorted(set(arrays) - set(known))
    if missing or unknown:
        found = [f"no array {', '.join(missing)}"] * bool(missing)
        found += [f"arrays {', '.join(unknown)}"] * bool(unknown)
        raise BadFile(
            path,
            found=" and ".join(found),
            expected=f"{', '.join(REQUIRED)}, and perhaps {', '.join((*JOINTS, *OPTIONAL))}",
            remedy="Name the arrays as docs/face.md does: nothing is told by its position.",
        )
    neutral = fitted("neutral", arrays["neutral"], np.float32, (None, 3))
    unit, V = metres_per_unit(path, neutral), len(neutral)
    values = {name: arrays[name] for name in ("triangles", *OPTIONAL) if name in arrays}
    for name, shape in OFFSETS.items():
        if name in arrays:
            values[name] = fitted(name, arrays[name], np.float32, (*shape, V, 3)) * unit
    for name, of in (("shape_names", "shapes"), ("identity_names", "identities")):
        if name in arrays:
            values[name] = names_of(name, arrays[name], len(values.get(of, ())))
    neutral = neutral * unit
    joints, skin = _joints(arrays, unit) if has_joints else head_only(neutral)
    return named(path, neutral=neutral, joints=joints, skin=skin, **values)


def _joints(arrays: dict[str, np.ndarray], unit: float) -> tuple[Sequence[Joint], np.ndarray]:
    parents = fitted("joint_parents", arrays["joint_parents"], np.int64, (None,))
    names = names_of("joint_names", arrays["joint_names"], len(parents))
    centres = fitted("joint_centres", arrays["joint_centres"], np.float32, (len(parents), 3))
    joints = [
        Joint(name, None if parent == -1 else parent, centre)
        for name, parent, centre in zip(names, parents.tolist(), centres * unit, strict=True)
    ]
    return joints, arrays["skin"]


def named(path: Path, **values) -> Face:
    """A Face whose shapes bear the channels' own names; arguments are those of Face.

    Raises BadFile where no shape is a channel and where shapes named Left move the right,
    Unfit as Face does.
    """
    names = [canonical(name) or name for name in values.pop("shape_names")]
    face = Face(shape_names=names, **values)
    if not any(driver(name) for name in names):
        some = ", ".join(names[:5]) or "none"
        raise BadFile(
            path,
            found=f"shapes {some}",
            expected="shapes named as ARKit channels (jawOpen, eyeBlinkLeft or eyeBlink_L, ...)",
            remedy="Name the shapes after the channels that they show.",
        )
    _refuse_swapped_sides(path, face)
    return face


def to_npz(face: Face, path: Path) -> None:
    """Write a face as an npz file that load_face reads; metres, text and plain arrays only."""
    arrays = {name: getattr(face, name) for name in (*REQUIRED, *OPTIONAL, "skin")}
    arrays = {name: value for name, value in arrays.items() if value is not None}
    for name in ("shape_names", "identity_names"):
        arrays[name] = np.array(arrays[name], np.str_)
    parents = [-1 if joint.parent is None else joint.parent for joint in face.joints]
    arrays["joint_names"] = np.array(face.joint_names, np.str_)
    arrays["joint_parents"] = np.int64(parents)
    arrays["joint_centres"] = np.float32([joint.centre for joint in face.joints]).reshape(-1, 3)
    with whole(path) as temporary, open(temporary, "wb") as file:  # savez adds .npz to a name
        np.savez_compressed(file, **arrays)


def metres_per_unit(path: Path, neutral: np.ndarray) -> float:
    """The unit of vertices (V, 3): a head's height is sure within a power of ten.

    Raises BadFile where no unit makes it the height of a head.
    """
    height = float(np.ptp(np.float64(neutral[:, 1]))) if len(neutral) else 0.0
    for unit in UNITS:
        if HEAD_HEIGHTS[0] <= height * unit <= HEAD_HEIGHTS[1]:
            return unit
    raise BadFile(
        path,
        found=f"a neutral face {height:.3g} high along y",
        expected=f"a head of {HEAD_HEIGHTS[0]}-{HEAD_HEIGHTS[1]} m, in m, dm, cm or mm, y up",
        remedy="Scale the model to metres and turn it upright.",
    )


def head_only(neutral: np.ndarray) -> tuple[Sequence[Joint], np.ndarray]:
    """A joint that turns the whole mesh, low in its middle, and its weights (V, 1)."""
    low, high = neutral.min(0), neutral.max(0)
    centre = 0.5 * (low + high)
    centre[1:] = [0.75 * low[1] + 0.25 * high[1], 0.7 * low[2] + 0.3 * high[2]]
    return [Joint("head", None, centre)], np.ones((len(neutral), 1), np.float32)


def _refuse_swapped_sides(path: Path, face: Face) -> None:
    """Raises BadFile where the shapes named Left move the subject's right."""
    middle = (face.neutral[:, 0].min() + face.neutral[:, 0].max()) / 2
    votes = []
    for name, shape in zip(face.shape_names, face.shapes, strict=True):
        side = next((s for s in ("Left", "Right") if name.endswith(s)), None)
        if side is None or name not in CHANNELS or CHANNELS[name].mirror == name:
            continue
        if name in ("jawLeft", "jawRight", "mouthLeft", "mouthRight"):
            continue  # these move the middle
        weight = np.linalg.norm(shape, axis=1)
        if weight.sum() > 0:
            x = float(weight @ (face.neutral[:, 0] - middle))
            votes.append(np.sign(x if side == "Left" else -x))
    if sum(votes) < 0:
        raise BadFile(
            path,
            found="shapes named Left that move the half with negative x",
            expected="the subject's left at positive x (+y up, +z out of the face)",
            remedy="Turn the model to face +z, or swap the names if they are the viewer's.",
        )
