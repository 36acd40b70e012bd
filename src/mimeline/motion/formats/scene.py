"""glTF: a face that moves, for Blender, three.js and engines."""

from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline.errors import BadFile
from mimeline.face import gltf
from mimeline.face.model import Face
from mimeline.face.motion import pose
from mimeline.face.rotations import angles_of
from mimeline.motion import about
from mimeline.motion.motion import Motion
from mimeline.tracking.take import Origin, assemble
from mimeline.vocabulary import GAZE, HEAD, canonical

SAME_RATE = 2e-4  # of it: float32 key times cannot tell closer
ON_KEY = 0.1  # frames: as far from a frame's start as a key may lie


def write(motion: Motion, path: Path, face: Face) -> tuple[str, ...]:
    """Write the face's motion with a key for each valid frame; between them it goes straight.

    Returns what glTF cannot say of the face. Raises BadFile for a motion without a valid frame.
    """
    frames = motion.frames[motion.frames["valid"].to_numpy(bool)]
    if frames.empty:
        raise BadFile(
            path,
            found="a motion without a valid frame",
            expected="at least one",
            remedy="Write a motion in which a face was tracked.",
        )
    times = frames["frame"].to_numpy() / float(motion.fps)
    return gltf.write(path, face, pose(face, frames), times, about.about(motion))


def read(path: Path, fps: Fraction | None) -> Motion:
    """The motion of a glTF file, ours or any whose morph targets bear channel names.

    fps: its rate; None: as the file of ours tells, else by the distance of its keys. The gaze is
    the mean of what both eyes do. Raises BadFile where no rate has a key at each of its frames.
    """
    done = gltf.read(path)
    rate = fps or about.rate(done.extras) or _rate_of(done.times, path)
    at = done.times * float(rate)
    frame = np.rint(at).astype(int)
    if (np.abs(at - frame) > ON_KEY).any() or (np.diff(frame) < 1).any() or frame[0] < 0:
        raise BadFile(
            path,
            found=f"keys that are not on frames of {float(rate):g} per second",
            expected="one key for a frame",
            remedy="Say its rate, --set fps=RATE, or export the animation with a key each frame.",
        )
    named = {c: v for name, v in done.weights.items() if (c := canonical(name))}
    channels = pd.DataFrame(named, index=range(len(frame)))
    if "head" in done.turns:
        channels[list(HEAD)] = np.stack(angles_of(done.turns["head"]), axis=1)
    eyes = [angles_of(done.turns[eye]) for eye in ("left_eye", "right_eye") if eye in done.turns]
    if eyes:
        channels[list(GAZE)] = np.mean([own[:2] for own in eyes], axis=0).T
    origins = {name: Origin(f"morph target {name}") for name in named}
    origins |= {name: Origin("node head") for name in HEAD if "head" in done.turns}
    origins |= {name: Origin("nodes leftEye and rightEye") for name in GAZE if eyes}
    frames = assemble(frame, np.ones(len(frame), bool), channels, np.nan, path)
    return about.informed(Motion(frames, rate, origins), done.extras)


def _rate_of(times: np.ndarray, path: Path) -> Fraction:
    """Frames per second, by the median distance of keys: whole, or thousands in 1001 seconds."""
    if len(times) < 2:
        raise BadFile(
            path,
            found="one key",
            expected="a motion, or its rate",
            remedy="Say how many frames a second has: --set fps=25.",
        )
    near = 1 / float(np.median(np.diff(times)))
    whole = Fraction(max(1, round(near)))
    rates = (whole, whole * Fraction(1000, 1001))
    best = min(rates, key=lambda rate: abs(float(rate) - near))
    return (
        best if abs(float(best) / near - 1) < SAME_RATE else Fraction(near).limit_denominator(1001)
    )
