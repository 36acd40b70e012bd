"""How often the timelines show each action, and which come together."""

from itertools import combinations

import numpy as np
import pandas as pd

from mimeline.annotation.runs import run_starts
from mimeline.dataset.split import PARTS
from mimeline.vocabulary import ACTIONS

LEAST_RUNS = 10  # of either action, below which what comes together may be chance


def action_counts(frames: pd.DataFrame, split: pd.DataFrame) -> pd.DataFrame:
    """A row per part and action.

    frames, split: the tables of these names. Returns part, action, measured (frames in which it
    could be told), frames (with it), share (of the measured ones; NaN without any), runs (stretches
    of consecutive frames with it) and clips (that show it).
    """
    told = frames.merge(split[["clip_id", "part"]], on="clip_id")
    told = told.sort_values(["clip_id", "frame"], ignore_index=True)
    rows = []
    for part in PARTS:
        own = told[told["part"] == part]
        keys, clip = own[["clip_id", "frame"]], pd.factorize(own["clip_id"])[0]
        values = own[list(ACTIONS)].to_numpy("float64", na_value=np.nan)  # (n_frames, 16)
        for action, value in zip(ACTIONS, values.T, strict=True):
            on, measured = value == 1, int(np.isfinite(value).sum())
            rows.append(
                {
                    "part": part,
                    "action": action,
                    "measured": measured,
                    "frames": int(on.sum()),
                    "share": on.sum() / measured if measured else np.nan,
                    "runs": int(on[run_starts(keys, on)].sum()) if len(on) else 0,
                    "clips": len(np.unique(clip[on])),
                }
            )
    return pd.DataFrame(rows)


def habits(frames: pd.DataFrame, counts: pd.DataFrame) -> pd.DataFrame:
    """Pairs of actions of different tracks, the most tied first.

    frames: the table's rows of training. counts: of `action_counts`; both actions have LEAST_RUNS
    in training. Returns action, other, together (share of the frames that measure both), lift (by
    how much that is more than if they had nothing to do with each other) and phi (their
    correlation, in [-1, 1]).
    """
    runs = counts[counts["part"] == "train"].set_index("action")["runs"]
    values = frames[list(ACTIONS)].to_numpy("float64", na_value=np.nan)  # (n, 16)
    column = dict(zip(ACTIONS, values.T, strict=True))
    rows = []
    for one, other in combinations([a for a in ACTIONS if runs[a] >= LEAST_RUNS], 2):
        both = np.isfinite(column[one]) & np.isfinite(column[other])
        a, b = column[one][both], column[other][both]
        if ACTIONS[one].track == ACTIONS[other].track or not len(a) or not a.std() or not b.std():
            continue
        together, chance = (a * b).mean(), a.mean() * b.mean()
        phi = (together - chance) / (a.std() * b.std())
        rows.append((one, other, together, together / chance, phi))
    found = pd.DataFrame(rows, columns=["action", "other", "together", "lift", "phi"])
    return found.sort_values("phi", key=abs, ascending=False, kind="stable", ignore_index=True)
