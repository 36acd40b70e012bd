"""How hard the world is. Frozen: figures from before and after a change here cannot be compared.

The jitter of the series regions is set so that a mixture of eight Gaussians on single frames, its
components named by an oracle, lands between .80 and .90 macro-F1 for brow, eye and mouth, while a
median over nine frames lifts it well above .92: what is hard is the jitter, which time takes away,
and not the actions. Thresholds alone land between .93 and .98 for closure, gaze and head.
`benchmarks/toy_difficulty.py` prints all of it over several seeds.
"""

import numpy as np

from mimeline.vocabulary import ACTIONS, CHANNELS, EXPRESSIONS, GAZE, HEAD

# Where a face rests: mean over people, by the start of the channel's name. The series channels rest
# above zero; clipped jitter would else pile up in a spike that is a class of its own.
REST = {
    "brow": 0.2,
    "eyeSquint": 0.18,
    "eyeWide": 0.18,
    "eyeBlink": 0.08,
    "mouthSmile": 0.16,
    "mouthStretch": 0.18,
    "mouthFrown": 0.18,
    "eyeLook": 0.0,
    "tongueOut": 0.0,
}
REST_ELSE = 0.06

# Amplitudes by variant (low, high, chance), above rest: moderate and strong, as in Ma et al. 2025.
_COEFFICIENT = ((0.27, 0.36, 0.5), (0.5, 0.68, 0.5))
_GAZE = ((0.22, 0.3, 0.5), (0.36, 0.5, 0.5))  # radians; half of each is about the 8 degrees limit
_HEAD = ((0.2, 0.26, 0.5), (0.28, 0.34, 0.5))  # radians; the strongest stays below 35 degrees
AMPLITUDE = {
    **dict.fromkeys(("BrowUp", "BrowDown", "EyeSquint", "EyeWiden", "MouthFrown"), _COEFFICIENT),
    "SoftSmile": ((0.3, 0.38, 1.0),),
    "Smile": ((0.68, 0.84, 1.0),),
    **{a.name: _GAZE for a in ACTIONS.values() if a.control_region == "gaze"},
    **{a.name: _HEAD for a in ACTIONS.values() if a.control_region == "head"},
}
CLOSURE = (0.65, 0.9)

# Standard deviation of the white jitter of a frame, by the start of the channel's name.
JITTER = {
    "brow": 0.14,
    "eyeSquint": 0.12,
    "eyeWide": 0.12,
    "eyeBlink": 0.11,
    "eyeLook": 0.0,  # follows the gaze angles, which have their own
    "mouthSmile": 0.11,
    "mouthStretch": 0.11,
    "mouthFrown": 0.11,
    "head": 0.03,  # radians
    "gaze": 0.04,  # radians
}
JITTER_ELSE = 0.02  # coefficients that no series is made of
JITTER_LOOK = 0.005  # what eyeLook channels and angles differ by

DRIFT = 0.015  # slow wander of a coefficient; small, as no filter over time takes it away
DRIFT_ANGLE = 0.02  # radians
DRIFT_FRAMES = 45  # between two turns of the drift

WANDER = {  # of a head and eyes that do nothing: theirs, not the tracker's; radians
    "head_yaw_left": 0.03,
    "head_pitch_up": 0.03,
    "head_tilt_left": 0.025,
    "gaze_left": 0.04,
    "gaze_up": 0.035,
}
WANDER_FRAMES = 24

LOWEST, HIGHEST = 0.0, 1.05  # what a coefficient is clipped to; real takes pass 1 a little


def rest() -> np.ndarray:
    """Mean resting values, (57,) in the order of CHANNELS; angles rest at zero."""
    return np.array([_by_start(REST, n, REST_ELSE) if n in EXPRESSIONS else 0.0 for n in CHANNELS])


def jitter() -> np.ndarray:
    """Standard deviation of the white jitter, (57,) in the order of CHANNELS."""
    return np.array([_by_start(JITTER, name, JITTER_ELSE) for name in CHANNELS])


def drift() -> np.ndarray:
    """Standard deviation of the slow drift, (57,) in the order of CHANNELS."""
    still = dict.fromkeys((n for n in EXPRESSIONS if n.startswith("eyeLook")), 0.0)
    angles = dict.fromkeys((*HEAD, *GAZE), DRIFT_ANGLE)
    return np.array([(still | angles).get(name, DRIFT) for name in CHANNELS])


def _by_start(values: dict[str, float], name: str, otherwise: float) -> float:
    return next((value for start, value in values.items() if name.startswith(start)), otherwise)
