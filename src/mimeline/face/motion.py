"""From a table of channels to the face's own numbers, and to its vertices."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from mimeline.face.model import Face
from mimeline.face.rotations import turned
from mimeline.vocabulary import canonical

# An eye's turn at an eyeLook coefficient of 1, radians: slopes of the eyes' yaw and pitch against
# these coefficients in a real Live Link take.
LOOK_SIDEWAYS, LOOK_UP, LOOK_DOWN = 0.60, 0.41, 0.61


@dataclass(frozen=True, eq=False)
class Pose:
    """What a face does in n frames: coefficients (n, S) in its shapes' order, (n, 3, 3) turns.

    The head turns in the subject's frame, the eyes in the head's.
    """

    coefficients: np.ndarray
    head: np.ndarray
    left_eye: np.ndarray
    right_eye: np.ndarray


def pose(face: Face, motion: pd.DataFrame) -> Pose:
    """The pose of a face in every row of a motion table.

    motion: columns named as vocabulary.CHANNELS, coefficients and radians; a channel that is
    absent or NaN was not measured and rests at 0. Other columns are ignored. The eyes turn by
    gaze_left and gaze_up where measured, else each by its own eyeLook coefficients.
    """
    coefficients = np.zeros((len(motion), len(face.shape_names)), np.float32)
    for number, name in enumerate(face.shape_names):
        channel = driver(name)
        if channel is not None:
            coefficients[:, number] = _measured(motion, channel, 0)
    rest = np.zeros(len(motion))
    head = turned(
        *(_measured(motion, f"head_{a}", 0) for a in ("yaw_left", "pitch_up", "tilt_left"))
    )
    eyes = []
    for side, outwards in (("Left", 1), ("Right", -1)):
        look = {
            way: _measured(motion, f"eyeLook{way}{side}", 0) for way in ("Up", "Down", "In", "Out")
        }
        left = outwards * LOOK_SIDEWAYS * (look["Out"] - look["In"])
        up = LOOK_UP * look["Up"] - LOOK_DOWN * look["Down"]
        left, up = _measured(motion, "gaze_left", left), _measured(motion, "gaze_up", up)
        eyes.append(turned(left, up, rest))
    return Pose(coefficients, head, *eyes)


def perform(face: Face, motion: pd.DataFrame) -> np.ndarray:
    """Vertices (n, V, 3) float32, metres, of a face that does what a motion table says.

    A turn for which the face has no joint is left out.
    """
    posed = pose(face, motion)
    turns = {"head": posed.head, "left_eye": posed.left_eye, "right_eye": posed.right_eye}
    turns = {name: turn for name, turn in turns.items() if name in face.joint_names}
    return face.vertices(posed.coefficients, turns)


def driver(shape_name: str) -> str | None:
    """The channel that drives a shape: its own name's, or the whole's where it is a half.

    ICT-FaceKit halves browInnerUp and cheekPuff into `_L` and `_R`.
    """
    channel = canonical(shape_name)
    if channel is None and shape_name[-2:].casefold() in ("_l", "_r"):
        channel = canonical(shape_name[:-2])
    return channel


def _measured(motion: pd.DataFrame, channel: str, otherwise) -> np.ndarray:
    """A channel (n,) with `otherwise`, a number or (n,), where it was not measured."""
    if channel not in motion.columns:
        return np.broadcast_to(np.float64(otherwise), len(motion))
    values = motion[channel].to_numpy(np.float64, na_value=np.nan)
    return np.where(np.isnan(values), otherwise, values)
