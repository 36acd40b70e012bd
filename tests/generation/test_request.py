from fractions import Fraction

import numpy as np
import pytest

from mimeline.generation.request import BadRequest, Request
from mimeline.timeline.timeline import Interval, Timeline
from mimeline.vocabulary import ACTIONS, TRACKS

ORDER = list(ACTIONS)


def timeline(*intervals: Interval, tracks=TRACKS) -> Timeline:
    by_track = {track: [i for i in intervals if i.track == track] for track in tracks}
    return Timeline("clip", Fraction(25), 10, by_track)


def on(values: np.ndarray, action: str) -> list[int]:
    return np.flatnonzero(values[:, ORDER.index(action)] == 1).tolist()


def test_an_interval_with_a_side_is_asked_of_that_half_and_any_other_of_both():
    asked = Request.of(
        timeline(
            Interval("BrowUp", 2, 4, side="left"),
            Interval("BrowDown", 2, 5, side="right"),
            Interval("Smile", 6, 8),
        )
    )
    assert (on(asked.left, "BrowUp"), on(asked.right, "BrowUp")) == ([2, 3], [])
    assert (on(asked.left, "BrowDown"), on(asked.right, "BrowDown")) == ([], [2, 3, 4])
    assert on(asked.left, "Smile") == on(asked.right, "Smile") == [6, 7]
    assert asked.left.sum() == 2 + 2
    assert asked.right.sum() == 3 + 2


def test_the_model_may_choose_on_tracks_that_a_timeline_does_not_measure():
    asked = Request.of(timeline(Interval("BrowUp", 2, 4), tracks=["brow", "head_h"]))
    measured = [action.track in ("brow", "head_h") for action in ACTIONS.values()]
    for half in (asked.left, asked.right):
        assert (half[:, measured] >= 0).all()
        assert (half[:, np.logical_not(measured)] == -1).all()


@pytest.mark.parametrize(
    ("values", "found"),
    [
        (np.zeros((9, 15)), r"an array of shape \(9, 15\)"),
        (np.zeros((9, 17)), r"an array of shape \(9, 17\)"),
        (np.zeros(16), r"an array of shape \(16,\)"),
        (np.zeros((0, 16)), r"an array of shape \(0, 16\)"),
        (np.full((9, 16), 0.5), "the value 0.5"),
        (np.full((9, 16), np.nan), "the value nan"),
    ],
)
def test_what_is_no_row_of_16_actions_per_frame_is_refused(values, found):
    with pytest.raises(BadRequest, match=f"found {found}, expected a row per frame"):
        Request.both_sides(values)


def test_halves_of_different_length_are_refused():
    with pytest.raises(BadRequest, match="right half of the face: found 8 frames where the left"):
        Request(np.zeros((9, 16)), np.zeros((8, 16)))


@pytest.mark.parametrize(
    ("channel", "values", "found"),
    [
        ("gaze_left", np.zeros(3), r"an array of shape \(3,\)"),
        ("gaze_left", np.array([0, np.nan, 0, 0]), "no finite number"),
        ("gazeLeft", np.zeros(4), "a name that is no channel's"),
    ],
)
def test_what_is_known_is_a_number_for_each_frame_of_a_channel(channel, values, found):
    nothing = np.zeros((4, len(ACTIONS)))
    with pytest.raises(BadRequest, match=f"known {channel}.*{found}"):
        Request(nothing, nothing, {channel: values})
