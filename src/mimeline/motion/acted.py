"""The motion that a timeline asks for, acted by rule: no model, and nobody's way of moving.

What an action moves is moved to one height and back, evenly; nothing comes with it. It shows what a
timeline says, not how a person would do it.
"""

import numpy as np

from mimeline.motion.motion import Motion
from mimeline.timeline.timeline import Interval, Timeline
from mimeline.tracking.take import Origin
from mimeline.vocabulary import CHANNELS, track_actions

RAMP_S = 0.28  # from rest to an action; the eyes and lids are faster
FAST_S = {"closure": 0.12, "gaze_h": 0.14, "gaze_v": 0.14}  # by track
MADE = "acted by rule from its timeline"

# Channel → its height, a coefficient or radians. A name without a side means both.
HEIGHTS: dict[str, dict[str, float]] = {
    "BrowUp": {"browInnerUp": 0.75, "browOuterUp": 0.7},
    "BrowDown": {"browDown": 0.8},
    "EyeSquint": {"eyeSquint": 0.8, "cheekSquint": 0.3},
    "EyeWiden": {"eyeWide": 0.8},
    "EyeClose": {"eyeBlink": 1.0},
    "SoftSmile": {"mouthSmile": 0.4},
    "Smile": {"mouthSmile": 0.85, "mouthDimple": 0.2},
    "MouthFrown": {"mouthFrown": 0.8, "mouthShrugLower": 0.3},
    "GazeLeft": {"gaze_left": 0.42},
    "GazeRight": {"gaze_left": -0.42},
    "GazeUp": {"gaze_up": 0.32},
    "GazeDown": {"gaze_up": -0.36},
    "HeadLeft": {"head_yaw_left": 0.38},
    "HeadRight": {"head_yaw_left": -0.38},
    "HeadUp": {"head_pitch_up": 0.28},
    "HeadDown": {"head_pitch_up": -0.28},
}


def acted(timeline: Timeline) -> Motion:
    """A motion that does what a timeline says, with the timeline.

    Each action has at least half its height exactly on its frames. Channels that no action of the
    timeline's tracks moves are NaN: nothing is said of them.
    """
    told = [c for track in timeline.tracks for a in track_actions(track) for c in _heights(a)]
    channels = tuple(name for name in CHANNELS if name in told)
    values = np.zeros((timeline.n_frames, len(channels)), np.float32)
    for interval in timeline:
        level = _level(interval, timeline)
        for name, height in _heights(interval.action, interval.side).items():
            values[:, channels.index(name)] += height * level
    origins = {name: Origin(MADE) for name in channels}
    return Motion.of_channels(values, channels, timeline.fps, origins, timeline, {"model": MADE})


def _heights(action: str, side: str | None = None) -> dict[str, float]:
    """Channel → height; of one side, what has no side goes half as far."""
    found = {}
    for name, height in HEIGHTS[action].items():
        for half in ("left", "right"):
            if (sided := f"{name}{half.capitalize()}") in CHANNELS and side in (None, half):
                found[sided] = height
        if name in CHANNELS:
            found[name] = height if side is None else height / 2
    return found


def _level(interval: Interval, timeline: Timeline) -> np.ndarray:
    """How far an action is done in each frame (n,), 0 to 1; what meets another passes into it.

    What begins or ends with the clip is taken to go on beyond.
    """
    seconds = FAST_S.get(interval.track, RAMP_S)
    ramp = max(1.0, min(seconds * float(timeline.fps), interval.end - interval.start))
    middle = np.arange(timeline.n_frames) + 0.5
    begun = _smoothstep((middle - interval.start) / ramp + 0.5) if interval.start else 1.0
    ends = interval.end < timeline.n_frames
    gone = _smoothstep((middle - interval.end) / ramp + 0.5) if ends else 0.0
    return np.broadcast_to(begun * (1 - gone), timeline.n_frames)


def _smoothstep(x: np.ndarray) -> np.ndarray:
    x = np.clip(x, 0, 1)
    return x * x * (3 - 2 * x)
