"""Actions that a limit decides: closed eyes, gaze and head (Ma et al. 2025, 3.1)."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from mimeline.annotation.runs import run_starts


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

    An action begins where its value reaches its limit and ends where it falls below
    limit * (1 - hysteresis), where its clip ends or frames are missing, and at a frame that is not
    valid or measured. Opposite directions exclude each other.

    motion: columns of the `motion` table, sorted by clip and frame.
    """
    lost = ~motion["valid"].to_numpy(bool)
    begins = lost.copy()  # (n_frames,) where what was before tells nothing
    begins[1:] |= lost[:-1]
    begins[run_starts(motion)] = True

    def shown(values: pd.Series, limit: float) -> pd.Series:
        return _shown(values, limit, limit * (1 - limits.hysteresis), begins)

    blink = motion[["eyeBlinkLeft", "eyeBlinkRight"]].mean(axis=1, skipna=False)
    gaze, head = np.radians(limits.gaze_deg), np.radians(limits.head_deg)
    return pd.DataFrame(
        {
            "EyeClose": shown(blink, limits.closed),
            "GazeLeft": shown(motion["gaze_left"], gaze),
            "GazeRight": shown(-motion["gaze_left"], gaze),
            "GazeUp": shown(motion["gaze_up"], gaze),
            "GazeDown": shown(-motion["gaze_up"], gaze),
            "HeadLeft": shown(motion["head_yaw_left"], head),
            "HeadRight": shown(-motion["head_yaw_left"], head),
            "HeadUp": shown(motion["head_pitch_up"], head),
            "HeadDown": shown(-motion["head_pitch_up"], head),
        }
    )


def _shown(values: pd.Series, limit: float, release: float, begins: np.ndarray) -> pd.Series:
    """Whether the value has reached limit since it was last below release, or since begins."""
    known = values.to_numpy("float32")  # the table's precision: a limit is itself
    row = np.arange(len(known))
    held = known >= np.float32(release)  # NaN is not
    reached = np.maximum.accumulate(np.where(known >= np.float32(limit), row, -1))
    since = np.maximum.accumulate(np.where(begins | ~held, row, 0))  # as far back as it counts
    on = pd.Series(held & (reached >= since), index=values.index, dtype="boolean")
    return on.mask(np.isnan(known))
