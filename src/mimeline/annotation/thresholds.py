"""Actions that a limit decides: closed eyes, gaze and head (Ma et al. 2025, 3.1)."""

from dataclasses import dataclass

import numpy as np
import pandas as pd


@dataclass(frozen=True)
class Limits:
    """closed: eyeBlink, mean of both eyes, from which they are closed. gaze_deg, head_deg: degrees
    from which an angle counts. hysteresis: share of a limit that an action which has begun may fall
    below it. min_frames: shorter intervals, of any track, become neutral."""

    closed: float
    gaze_deg: float
    head_deg: float
    hysteresis: float
    min_frames: int


def threshold_actions(motion: pd.DataFrame, limits: Limits) -> pd.DataFrame:
    """The nine actions of closure, gaze and head at each frame; pd.NA where not measured.

    motion: columns of the `motion` table.
    """
    blink = motion[["eyeBlinkLeft", "eyeBlinkRight"]].mean(axis=1, skipna=False)
    gaze, head = np.radians(limits.gaze_deg), np.radians(limits.head_deg)
    return pd.DataFrame(
        {
            "EyeClose": _at_least(blink, limits.closed),
            "GazeLeft": _at_least(motion["gaze_left"], gaze),
            "GazeRight": _at_least(-motion["gaze_left"], gaze),
            "GazeUp": _at_least(motion["gaze_up"], gaze),
            "GazeDown": _at_least(-motion["gaze_up"], gaze),
            "HeadLeft": _at_least(motion["head_yaw_left"], head),
            "HeadRight": _at_least(-motion["head_yaw_left"], head),
            "HeadUp": _at_least(motion["head_pitch_up"], head),
            "HeadDown": _at_least(-motion["head_pitch_up"], head),
        }
    )


def _at_least(values: pd.Series, limit: float) -> pd.Series:
    on = values.astype("float32") >= np.float32(limit)  # the table's precision: a limit is itself
    return on.astype("boolean").mask(values.isna())
