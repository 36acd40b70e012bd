from fractions import Fraction

import numpy as np
import pytest

from mimeline.motion.acted import HEIGHTS, acted
from mimeline.timeline.timeline import Interval, Timeline
from mimeline.vocabulary import ACTIONS, track_actions

FRAMES = 60


def of(**tracks) -> Timeline:
    return Timeline("clip", Fraction(30), FRAMES, tracks)


def level(frames, action: str) -> np.ndarray:
    """How far an action goes in each frame, by the first channel that it moves."""
    name, height = next(iter(HEIGHTS[action].items()))
    column = name if name in frames else f"{name}Left"
    return frames[column].to_numpy() / height


@pytest.mark.parametrize("action", ACTIONS)
@pytest.mark.parametrize("start, end", [(10, 45), (10, 11), (20, 23), (0, 20), (40, FRAMES)])
def test_an_action_has_half_its_height_on_exactly_its_frames(action, start, end):
    timeline = of(**{ACTIONS[action].track: [Interval(action, start, end)]})
    held = np.flatnonzero(level(acted(timeline).frames, action) >= 0.5)
    assert held.tolist() == list(range(start, end))


def test_a_side_is_the_subjects_and_the_other_side_rests():
    sided = [Interval("BrowUp", 5, 30, side="left"), Interval("BrowDown", 20, 50, side="right")]
    frames = acted(of(brow=sided)).frames
    assert frames["browOuterUpRight"].max() == 0 < frames["browOuterUpLeft"].max()
    assert frames["browDownLeft"].max() == 0 < frames["browDownRight"].max()
    assert frames["browInnerUp"].max() == pytest.approx(HEIGHTS["BrowUp"]["browInnerUp"] / 2)


def test_what_no_track_tells_of_is_not_known_and_what_one_does_rests():
    motion = acted(of(mouth=[], head_h=[Interval("HeadLeft", 15, 50)]))
    assert motion.frames[["gaze_left", "jawOpen", "browInnerUp"]].isna().all(axis=None)
    assert (motion.frames["mouthSmileLeft"] == 0).all()
    assert motion.frames["head_yaw_left"].max() == pytest.approx(0.38)
    assert motion.origins.keys() == set(motion.moved) and motion.timeline.n_frames == FRAMES


def test_one_action_passes_into_the_next_of_its_track():
    frames = acted(of(mouth=[Interval("SoftSmile", 10, 30), Interval("Smile", 30, 50)])).frames
    smile = frames["mouthSmileLeft"].to_numpy()
    assert (np.diff(smile[5:45]) >= -1e-6).all()


def test_every_action_moves_channels_that_no_other_of_its_track_undoes():
    assert set(HEIGHTS) == set(ACTIONS)
    for track in ("brow", "lid", "mouth"):
        assert all(min(HEIGHTS[action].values()) > 0 for action in track_actions(track))
