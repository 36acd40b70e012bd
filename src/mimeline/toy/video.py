"""The clips' videos: each person's face in the clip's true motion, with the voice to it."""

from collections.abc import Iterator
from fractions import Fraction
from itertools import repeat
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline.face.motion import perform
from mimeline.face.render import Camera, film
from mimeline.media.film import write_film
from mimeline.toy import scenery
from mimeline.toy.appearance import Appearance, Colour, background
from mimeline.toy.plan import PlannedClip
from mimeline.toy.voice import RATE, voice

GOLDEN = (5**0.5 - 1) / 2


def has_turn(index: int, share: float) -> bool:
    """Whether a clip is of the share that have a video: evenly spread, the same in any count."""
    return (index + 1) * GOLDEN % 1 < share


def shoot(
    path: Path,
    clip: PlannedClip,
    looks: Appearance,
    motion: pd.DataFrame,
    speech: np.ndarray,
    covered: np.ndarray,
    shown: np.ndarray,
    size: int,
    seed: int,
) -> None:
    """Write a clip's video, H.264 with sound, size x size pixels.

    motion: the clip's clean rows of table `motion` · speech (n_frames,) in [0, 1] · covered
    (n_frames,) bool, where something hides the face · shown (k,) frames that the file has, in
    order; fewer than all make a variable rate whose time stamps are true.
    """
    if clip.deserted:
        pictures = repeat(scenery.room(size), len(shown))
    else:
        wall = background(clip.source, seed)
        pictures = _portrait(looks, motion.iloc[shown], size, wall)
    raised = scenery.raised(covered)[shown]
    pictures = (scenery.behind_paper(p, up) for p, up in zip(pictures, raised, strict=True))
    write_film(
        path,
        pictures,
        Fraction(clip.fps),
        sound=voice(speech, clip.fps, looks.pitch_hz, np.random.default_rng([seed, 8, clip.index])),
        sound_rate=RATE,
        times=shown / clip.fps if len(shown) < clip.n_frames else None,
    )


def _portrait(
    looks: Appearance, motion: pd.DataFrame, size: int, wall: Colour
) -> Iterator[np.ndarray]:
    face = looks.face()
    return film(face, perform(face, motion), Camera.framing(face, size), wall)
