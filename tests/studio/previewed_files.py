"""Small files to preview: a motion with its timeline, one with holes and none, timelines alone."""

from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from mimeline.face.load import load_face
from mimeline.motion import files
from mimeline.motion.motion import Motion
from mimeline.timeline import files as timelines
from mimeline.timeline.timeline import Interval, Timeline
from mimeline.tracking.take import Origin
from mimeline.vocabulary import CHANNELS

FRAMES, FPS = 60, Fraction(30)
TRACKED_FPS = Fraction(25)
INVALID = range(20, 30)
HOSTILE = '<img src=x onerror="document.title=1">'  # one clip is called so
WAVED = {"jawOpen": 0.6, "browInnerUp": 0.8, "mouthSmileLeft": 0.7, "eyeBlinkRight": 1.0}
TURNED = {"head_yaw_left": 0.5, "head_pitch_up": -0.2, "gaze_left": 0.4}


def make(folder: Path) -> SimpleNamespace:
    """Write them; returns their paths, and the motion of the first."""
    face, motion = load_face(None), generated()
    paths = SimpleNamespace(motion=motion)
    paths.glb, paths.npz = folder / "made.glb", folder / "tracked.npz"
    paths.timelines, paths.rows = folder / "timelines.json", folder / "rows.csv"
    files.write(motion, paths.glb, face)
    files.write(tracked(), paths.npz, face)
    own = [timeline("first"), timeline(HOSTILE)]
    timelines.write_all(own, paths.timelines)
    timelines.write(timeline("first"), paths.rows)
    return paths


def timeline(name: str) -> Timeline:
    tracks = {
        "brow": [
            Interval("BrowUp", 6, 30, side="left"),
            Interval("BrowDown", 20, 40, side="right"),
        ],
        "closure": [],
        "mouth": [Interval("Smile", 10, 45)],
        "head_h": [Interval("HeadLeft", 15, 50)],
    }
    return Timeline(name, FPS, FRAMES, tracks)


def generated() -> Motion:
    """All at once, so that a wrong order of anything is seen."""
    names = tuple({**WAVED, **TURNED})
    at = np.linspace(0, 2 * np.pi, FRAMES)
    heights = {**WAVED, **TURNED}.values()
    values = np.stack([h * np.sin(at / 2 + n / 3) ** 2 for n, h in enumerate(heights)], axis=1)
    origins = {name: Origin("made", quality=0.3 if name == "jawOpen" else None) for name in names}
    made = {"model": "a model", "seed": 7}
    return Motion.of_channels(values, names, FPS, origins, timeline("first"), made)


def tracked() -> Motion:
    """A recording of another rate, in whose middle the face was lost."""
    motion = generated()
    frames = motion.frames.copy()
    frames.loc[[*INVALID], [*CHANNELS]] = np.float32(np.nan)
    frames.loc[[*INVALID], "valid"] = False
    origins = {name: Origin(f"column {name}") for name in motion.moved}
    return Motion(frames, TRACKED_FPS, origins)
