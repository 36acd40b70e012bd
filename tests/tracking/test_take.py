from dataclasses import replace
from fractions import Fraction

import numpy as np
import pandas as pd
import pytest

from mimeline.tracking.take import Origin, Take, assemble
from mimeline.vocabulary import CHANNELS


@pytest.fixture
def take(tmp_path) -> Take:
    """Six frames with every channel, the third not valid, and two tables beside."""
    values = np.random.default_rng(0).uniform(0, 0.5, (6, len(CHANNELS)))
    valid = np.arange(6) != 2
    motion = assemble(
        np.arange(6), valid, pd.DataFrame(values, columns=list(CHANNELS)), 0.9, tmp_path / "take"
    )
    units = pd.DataFrame({"AU12_r": np.arange(6.0)})
    origins = {"mouthSmileLeft": Origin("column left"), "jawOpen": Origin("jaw")}
    coefficients = {"action_units": units, "flame": pd.DataFrame({"exp000": np.arange(6.0)})}
    return Take(motion, Fraction(30), coefficients, origins)


def test_a_part_of_a_take_has_its_own_frames_and_coefficients(take):
    part = take.cut(3, 5)
    assert part.motion["frame"].tolist() == [0, 1]
    assert part.coefficients["flame"]["exp000"].tolist() == [3, 4]
    assert part.origins == take.origins


def test_only_a_part_from_its_beginning_has_the_number_of_the_first_frame(take):
    counted = replace(take, first_frame=1, numbered=True)
    assert [counted.cut(start, 5).first_frame for start in (0, 1)] == [1, None]
    assert counted.cut(1, 5).numbered and not take.cut(1, 5).numbered


def test_a_padded_take_has_frames_that_are_not_valid_and_hold_no_number(take):
    longer = take.padded(8)
    assert longer.motion["valid"].tolist() == [True, True, False, True, True, True, False, False]
    assert longer.motion[list(CHANNELS)].iloc[6:].isna().all(axis=None)
    assert longer.coefficients["action_units"]["AU12_r"].iloc[6:].isna().all()
    assert len(take.padded(3).motion) == 6


def test_mirroring_swaps_sides_negates_yaw_and_tilt_and_is_its_own_inverse(take):
    other = take.mirrored()
    for left, right in (("mouthSmileLeft", "mouthSmileRight"), ("eyeBlinkRight", "eyeBlinkLeft")):
        pd.testing.assert_series_equal(other.motion[left], take.motion[right], check_names=False)
    for name, sign in (("head_yaw_left", -1), ("head_pitch_up", 1), ("head_tilt_left", -1)):
        pd.testing.assert_series_equal(other.motion[name], sign * take.motion[name])
    assert set(other.coefficients) == {"action_units"}  # a face model's have no named sides
    assert other.origins["mouthSmileRight"].text == "column left"
    pd.testing.assert_frame_equal(other.mirrored().motion, take.motion)
