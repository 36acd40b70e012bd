from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pandas as pd
import pytest

from mimeline.face.embedded import embedded_face
from mimeline.motion.motion import Motion
from mimeline.timeline.timeline import Interval, Timeline
from mimeline.tracking.take import Origin, assemble
from mimeline.vocabulary import CHANNELS, EXPRESSIONS

NEVER = ("tongueOut", "gaze_left", "gaze_up")


@pytest.fixture(scope="session")
def face():
    return embedded_face()


@pytest.fixture(scope="session")
def moving() -> Callable[..., Motion]:
    """A motion of n frames: three channels are never known, one not in every frame, and no face is
    seen in frames 3 and 4."""

    def make(n: int = 12, fps: Fraction = Fraction(30_000, 1001), seed: int = 0) -> Motion:
        rng = np.random.default_rng(seed)
        values = {name: rng.uniform(0, 1, n) for name in CHANNELS if name not in NEVER}
        values |= {n_: v - 0.5 for n_, v in values.items() if n_ not in EXPRESSIONS}
        values["jawOpen"][n // 2 :] = np.nan
        valid = ~np.isin(np.arange(n), (3, 4))
        frames = assemble(np.arange(n), valid, pd.DataFrame(values), np.nan, "motion")
        origins = {name: Origin(f"column {name}", quality=0.25) for name in values}
        origins |= {name: Origin("not given", measured=False) for name in NEVER}
        smile = Interval("Smile", 1, n // 2, side="left")
        timeline = Timeline("mine", fps, n, {"mouth": [smile], "brow": []})
        return Motion(frames, fps, origins, timeline, {"model": "m", "seed": 3})

    return make
