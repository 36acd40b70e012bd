"""Made-up timelines of gazes alone, and motion in which the head follows them."""

import numpy as np
import pandas as pd

from mimeline.evaluation.coupling import FOLLOWS, LAG
from mimeline.vocabulary import ACTIONS, CHANNELS, track_actions

GAZES = [action for track in FOLLOWS for action in track_actions(track)]


def glances(rng: np.random.Generator) -> np.ndarray:
    """(160, 16) bool: two held gazes, one after the other, each to any side."""
    timeline = np.zeros((160, len(ACTIONS)), bool)
    for first in (20, 90):
        timeline[first : first + 50, list(ACTIONS).index(rng.choice(GAZES))] = True
    return timeline


def followed(frames: pd.DataFrame, law: float, rng: np.random.Generator) -> pd.DataFrame:
    """`motion` of these `frames`: gazes of any size, and a head that goes by a share of each."""
    values = {name: rng.uniform(0, 0.2, len(frames)) for name in CHANNELS}
    for track, (gaze, head, _) in FOLLOWS.items():
        on = frames[list(track_actions(track))].to_numpy(bool)
        run = np.cumsum(np.diff(on.any(axis=1), prepend=False) & on.any(axis=1))  # of each gaze
        size = rng.uniform(0.2, 0.5, run.max() + 1)[run]
        values[gaze] = size * (on[:, 0].astype(float) - on[:, 1])
        values[head] = law * np.roll(values[gaze], LAG)
    facts = {"valid": True, "confidence": np.nan, "tracker_loss": np.nan}
    return frames[["clip_id", "frame"]].assign(**facts, **values)
