"""From planted actions to channels: what each action moves, and what it moves on the side.

The couplings are those that the papers argue from: a smile squints the eye and lowers the brow, a
gaze shift drifts the head, a brow raise lifts it. They stay below what counts as an action.
"""

import numpy as np

from mimeline.vocabulary import CHANNELS

INDEX = {name: position for position, name in enumerate(CHANNELS)}

# Gain per unit of an action's amplitude. A name without a side means both sides.
EXPRESSIVE: dict[str, dict[str, float]] = {
    "BrowUp": {"browInnerUp": 1.0, "browOuterUp": 0.9, "head_pitch_up": 0.06},
    "BrowDown": {"browDown": 1.0, "noseSneer": 0.15},
    "EyeSquint": {"eyeSquint": 1.0, "cheekSquint": 0.35},
    "EyeWiden": {"eyeWide": 1.0},
    "EyeClose": {"eyeBlink": 1.0, "eyeSquint": 0.08},
    "SoftSmile": {"mouthSmile": 1.0, "mouthDimple": 0.15, "eyeSquint": 0.08, "browDown": 0.05},
    "Smile": {
        "mouthSmile": 1.0,
        "mouthDimple": 0.25,
        "cheekSquint": 0.4,
        "eyeSquint": 0.08,
        "browDown": 0.05,
    },
    "MouthFrown": {"mouthFrown": 1.0, "mouthShrugLower": 0.4, "mouthStretch": 0.15},
}
# Sign of the angle, in radians of amplitude; the head follows a gaze by HEAD_FOLLOWS of its angle.
ANGULAR: dict[str, tuple[str, int]] = {
    "GazeLeft": ("gaze_left", 1),
    "GazeRight": ("gaze_left", -1),
    "GazeUp": ("gaze_up", 1),
    "GazeDown": ("gaze_up", -1),
    "HeadLeft": ("head_yaw_left", 1),
    "HeadRight": ("head_yaw_left", -1),
    "HeadUp": ("head_pitch_up", 1),
    "HeadDown": ("head_pitch_up", -1),
}
HEAD_FOLLOWS = 0.15
FOLLOWS = {"gaze_left": "head_yaw_left", "gaze_up": "head_pitch_up"}
HEAD_LAG = 4  # frames that the head comes after the eyes

SPEECH = {
    "jawOpen": 0.45,
    "mouthLowerDown": 0.3,
    "mouthUpperUp": 0.15,
    "mouthStretch": 0.06,
}
ROUNDING = {"mouthFunnel": 0.35, "mouthPucker": 0.3}

RAD_PER_LOOK = 0.6  # gaze angle at which an eyeLook channel is 1, as in Live Link Face takes
LID_FOLLOWS = 0.25  # eyeBlink per unit of eyeLookDown: the lid goes down with the eye


def vector(gains: dict[str, float]) -> np.ndarray:
    """Gains by name as (57,) in the order of CHANNELS; a name without a side means both."""
    gain = np.zeros(len(INDEX))
    for name, value in gains.items():
        for sided in (name, f"{name}Left", f"{name}Right"):
            if sided in INDEX:
                gain[INDEX[sided]] = value
    return gain


GAIN = {action: vector(gains) for action, gains in EXPRESSIVE.items()}
GAIN |= {action: vector({angle: sign}) for action, (angle, sign) in ANGULAR.items()}
SPEECH_GAIN, ROUNDING_GAIN = vector(SPEECH), vector(ROUNDING)


def look(motion: np.ndarray) -> None:
    """Write the eyeLook channels that the gaze angles of motion (n, 57) imply, in place."""
    left, up = (motion[:, INDEX[name]] / RAD_PER_LOOK for name in ("gaze_left", "gaze_up"))
    for name, value in (
        ("eyeLookOutLeft", left),
        ("eyeLookInRight", left),
        ("eyeLookInLeft", -left),
        ("eyeLookOutRight", -left),
        ("eyeLookUpLeft", up),
        ("eyeLookUpRight", up),
        ("eyeLookDownLeft", -up),
        ("eyeLookDownRight", -up),
    ):
        motion[:, INDEX[name]] = np.maximum(value, 0)
