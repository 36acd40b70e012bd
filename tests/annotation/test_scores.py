import numpy as np
import pandas as pd
import pytest

from mimeline.annotation.scores import bootstrap, confusions, macro_f1, region_scores
from mimeline.vocabulary import ACTIONS


def frames_of(measured=tuple(ACTIONS), **tracks) -> pd.DataFrame:
    """A `frames` table of one clip; tracks: action → a mark per frame, x on, o off, ? unknown."""
    rows = max(map(len, tracks.values()))
    table = pd.DataFrame({"clip_id": "a", "frame": range(rows)})
    marks = {"x": True, "o": False, "?": pd.NA}
    for name in ACTIONS:
        off = "o" if name in measured else "?"
        values = [marks[c] for c in tracks.get(name, off * rows)]
        table[name] = pd.array(values, dtype="boolean")
    return table


def test_a_known_confusion_has_its_macro_f1():
    # neutral: 6 hits of 8 true and 7 found; first: 3 of 4 and 5
    confusion = np.array([[6, 2], [1, 3]])
    assert macro_f1(confusion) == pytest.approx((12 / 15 + 6 / 9) / 2)


def test_a_class_that_neither_has_does_not_count_and_one_that_is_made_up_does():
    assert macro_f1(np.array([[5, 0, 0], [0, 5, 0], [0, 0, 0]])) == pytest.approx(1)
    assert macro_f1(np.array([[5, 0, 0], [0, 4, 1], [0, 0, 0]])) == pytest.approx((1 + 8 / 9) / 3)


def test_frames_are_counted_by_truth_in_rows():
    true = frames_of(BrowUp="xxxooo", BrowDown="oooxoo")
    pred = frames_of(BrowUp="xxoxoo", BrowDown="oooooo")
    brow = confusions(true, pred)["brow"]
    assert brow.tolist() == [[[2, 0, 0], [1, 2, 0], [0, 1, 0]]]


def test_the_same_timeline_scores_one_in_every_region():
    table = frames_of(BrowUp="xo", EyeSquint="xo", Smile="ox", GazeUp="xo", HeadLeft="ox")
    scores = region_scores(table, table)
    assert list(scores) == ["brow", "eye", "closure", "mouth", "gaze", "head"]
    assert set(scores.values()) == {1.0}


@pytest.mark.parametrize("blind", ["prediction", "truth"])
def test_an_action_that_one_side_does_not_measure_is_left_out_and_the_others_score(blind):
    both = (
        frames_of(Smile="xxooo", MouthFrown="ooxoo"),
        frames_of(Smile="xoxoo", MouthFrown="?????"),
    )
    mouth = confusions(*(both if blind == "prediction" else both[::-1]))["mouth"][0]
    counts = np.zeros((4, 4), dtype=int)
    counts[0, 0], counts[2, 2] = 2, 1
    counts[(2, 0) if blind == "prediction" else (0, 2)] = 1
    assert mouth.tolist() == counts.tolist()


def test_gaze_is_the_mean_of_its_two_tracks():
    true = frames_of(GazeLeft="xxoo", GazeUp="xxoo")
    pred = frames_of(GazeLeft="xxoo", GazeUp="ooxx")
    assert region_scores(true, pred)["gaze"] == pytest.approx(0.5)


def test_the_eye_counts_only_where_truth_does_not_close_it():
    true = frames_of(EyeSquint="xxoo", EyeClose="ooxx")
    pred = frames_of(EyeSquint="xxxx", EyeClose="xxxx")
    scores = region_scores(true, pred)
    assert scores["eye"] == 1
    assert scores["closure"] == pytest.approx((0 + 2 * 2 / 6) / 2)


def test_the_eye_counts_where_closing_is_unknown():
    true = frames_of(EyeSquint="xo", EyeClose="??")
    assert confusions(true, true)["lid"].sum() == 2


@pytest.mark.parametrize("blind", ["truth", "prediction"])
def test_what_one_side_does_not_measure_has_no_score(blind):
    full = frames_of(BrowUp="xo")
    part = frames_of(measured=["BrowUp", "BrowDown", "HeadUp", "HeadDown"], BrowUp="xo")
    both = (part, full) if blind == "truth" else (full, part)
    assert region_scores(*both) == {"brow": 1.0, "head": 1.0}


def test_frames_that_only_one_table_has_and_unknown_frames_are_left_out():
    true = frames_of(BrowUp="xxoo?x")
    pred = frames_of(BrowUp="xx?oo")
    assert confusions(true, pred)["brow"].sum() == 3
    assert region_scores(true, pred)["brow"] == 1
    assert region_scores(true, pred.assign(clip_id="b")) == {}


def clips_of(seed, n=30):
    """Confusions of n clips, nine in ten frames right."""
    rng = np.random.default_rng(seed)
    right = rng.integers(30, 60, (n, 3))
    counts = np.einsum("ni,ij->nij", right, np.eye(3, dtype=int))
    return counts + rng.integers(0, 6, (n, 3, 3))


def test_an_interval_holds_the_value_and_repeats_for_a_seed():
    counts = {"brow": clips_of(0), "gaze_h": clips_of(1), "gaze_v": clips_of(2)}
    first = bootstrap(counts, 200, np.random.default_rng(5))
    assert list(first) == ["mean", "brow", "gaze"]
    assert first["mean"][0] == pytest.approx((first["brow"][0] + first["gaze"][0]) / 2)
    for value, low, high in first.values():
        assert low < value < high
        assert high - low < 0.1
    assert first["brow"][0] == pytest.approx(macro_f1(counts["brow"].sum(axis=0)))
    assert bootstrap(counts, 200, np.random.default_rng(5)) == first
    assert bootstrap(counts, 200, np.random.default_rng(6)) != first


def test_one_clip_gives_a_score_and_no_interval():
    value, low, high = bootstrap({"brow": clips_of(0, n=1)}, 50, np.random.default_rng(0))["brow"]
    assert 0 < value < 1
    assert np.isnan([low, high]).all()


def test_clips_that_do_not_measure_a_region_do_not_widen_its_interval():
    counts = clips_of(0, n=3)
    padded = np.concatenate([counts[:1], np.zeros((9, 3, 3), dtype=int)])
    value, low, high = bootstrap({"brow": padded}, 200, np.random.default_rng(0))["brow"]
    assert value == low == high > 0.5


def test_a_region_of_which_truth_holds_no_action_does_not_lift_the_mean():
    calm = np.array([[[50, 0], [0, 0]]])
    scored = bootstrap({"brow": clips_of(0, n=1), "closure": calm}, 20, np.random.default_rng(0))
    assert scored["closure"][0] == 1
    assert scored["mean"][0] == pytest.approx(scored["brow"][0])


def test_nothing_in_common_gives_no_score():
    assert bootstrap({}, 10, np.random.default_rng(0)) == {}
