import numpy as np
import pandas as pd
import pytest

from mimeline.annotation.thresholds import Limits, threshold_actions
from mimeline.vocabulary import HEAD

LIMITS = {"closed": 0.5, "gaze_deg": 8.0, "head_deg": 10.0, "min_frames": 1}


def marks(motion_of, limits=LIMITS, **channels):
    """The actions of one clip, by name; float32 as a `motion` table has it."""
    rows = max(np.size(values) for values in channels.values())
    motion = motion_of({"a": rows}, **channels)
    numbers = motion.columns[3:]
    return threshold_actions(motion.astype(dict.fromkeys(numbers, "float32")), Limits(**limits))


def test_the_exact_limit_counts_as_on_and_what_is_below_does_not(motion_of):
    blink = np.array([0.5, 0.499, 0.501])
    found = marks(motion_of, eyeBlinkLeft=blink, eyeBlinkRight=blink)
    assert found["EyeClose"].tolist() == [True, False, True]


@pytest.mark.parametrize("degrees", [5.0, 7.3, 8.0, 9.0, 12.0, 20.0, 33.3])
def test_an_angle_at_the_limit_counts_whatever_its_rounding(motion_of, degrees):
    yaw = np.radians([degrees, -degrees, degrees - 0.01])
    found = marks(motion_of, LIMITS | {"head_deg": degrees}, head_yaw_left=yaw)
    assert found["HeadLeft"].tolist() == [True, False, False]
    assert found["HeadRight"].tolist() == [False, True, False]


def test_each_angle_moves_its_own_two_actions(motion_of):
    cases = {
        "gaze_left": ("GazeLeft", "GazeRight"),
        "gaze_up": ("GazeUp", "GazeDown"),
        "head_yaw_left": ("HeadLeft", "HeadRight"),
        "head_pitch_up": ("HeadUp", "HeadDown"),
    }
    angles = dict.fromkeys([*cases, HEAD[-1]], 0.0)
    for channel, (positive, negative) in cases.items():
        found = marks(motion_of, **angles | {channel: np.radians([15.0, -15.0, 3.0])})
        on = {name: found[name].tolist() for name in found if found[name].any()}
        assert on == {positive: [True, False, False], negative: [False, True, False]}


def test_both_eyes_count_by_their_mean(motion_of):
    found = marks(motion_of, eyeBlinkLeft=np.array([1.0, 0.7]), eyeBlinkRight=np.array([0.25, 0.2]))
    assert found["EyeClose"].tolist() == [True, False]


def test_what_is_not_measured_is_unknown_and_not_off(motion_of):
    gaps = np.array([0.4, np.nan])
    found = marks(motion_of, eyeBlinkLeft=0.9, eyeBlinkRight=gaps, gaze_left=gaps)
    assert found.loc[0, ["EyeClose", "GazeLeft", "GazeRight"]].tolist() == [True, True, False]
    assert found.loc[1, ["EyeClose", "GazeLeft", "GazeRight"]].isna().all()
    assert found[["GazeUp", "GazeDown", "HeadLeft", "HeadUp"]].isna().all(axis=None)
    assert all(isinstance(kind, pd.BooleanDtype) for kind in found.dtypes)
