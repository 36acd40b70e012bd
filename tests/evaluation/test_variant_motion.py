import numpy as np
import pandas as pd
import pytest

from mimeline.evaluation.requests import as_frames
from mimeline.evaluation.variant_motion import eyes
from mimeline.vocabulary import ACTIONS

from ..glances import followed, glances


@pytest.fixture
def clips() -> tuple[pd.DataFrame, pd.DataFrame]:
    rng = np.random.default_rng(0)
    frames = as_frames("clip", [glances(rng) for _ in range(2)], set(ACTIONS))
    return frames, followed(frames, 0.15, rng)


def test_eyes_are_those_of_each_clip_times_how_far(clips):
    frames, motion = clips
    found = eyes(frames, motion, ["jawOpen", "gaze_left", "eyeLookUpLeft"], 1.25)
    assert list(found) == ["clip-000", "clip-001"]
    for clip, known in found.items():
        own = motion[motion["clip_id"] == clip]
        assert set(known) == {"gaze_left", "eyeLookUpLeft"}
        np.testing.assert_allclose(known["gaze_left"], 1.25 * own["gaze_left"])


def test_what_is_not_measured_is_bridged_and_a_channel_never_measured_left_out(clips):
    frames, motion = clips
    first = motion["clip_id"] == "clip-000"
    motion.loc[first, "gaze_up"] = np.nan
    motion["gaze_left"] = motion["frame"] / 100
    motion.loc[first & motion["frame"].between(10, 19), "gaze_left"] = np.nan
    motion.loc[first & motion["frame"].between(30, 39), ["valid", "gaze_left"]] = [False, 9.0]
    found = eyes(frames, motion, ["gaze_left", "gaze_up"], 1.0)
    assert set(found["clip-000"]) == {"gaze_left"}
    assert set(found["clip-001"]) == {"gaze_left", "gaze_up"}
    np.testing.assert_allclose(found["clip-000"]["gaze_left"], np.arange(160) / 100)
