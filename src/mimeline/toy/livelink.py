"""The phone that tracks the toy world's people: its clock, and the convergence of its eyes."""

import numpy as np
import pandas as pd

from mimeline.tracking.formats import livelink

BASE = 60  # what the timecode counts in, per second
STEP = 2 - 0.00027  # 60ths between two frames at 30 fps: the phone's clock runs a little fast
VERGENCE = 0.03  # radians that each eye turns in


def timecode_start(rng: np.random.Generator) -> float:
    """A time of day at which a take may begin, in 60ths since midnight."""
    return float(rng.uniform(8 * 3600, 18 * 3600) * BASE)


def lines(motion: pd.DataFrame, start: float) -> list[str]:
    """The lines of a clip's Live Link Face file, header first.

    motion: the clip's rows of table `motion`. start: timecode of frame 0, in 60ths since midnight.
    """
    return livelink.lines(motion, start, STEP, BASE, VERGENCE)
