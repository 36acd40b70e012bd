import numpy as np
import pytest

from mimeline.annotation.resting import resting_place, resting_places


def faces(*parts, seed=0, sd=0.03):
    """Frames around places, so many around each: values (n, d)."""
    rng = np.random.default_rng(seed)
    return np.concatenate([np.array(at) + sd * rng.normal(size=(n, len(at))) for at, n in parts])


def test_a_face_rests_where_most_frames_are():
    values = faces(((0.1, 0.2), 500), ((0.6, 0.2), 200), ((0.1, 0.7), 300))
    assert resting_place(values) == pytest.approx([0.1, 0.2], abs=0.02)


def test_a_channel_that_rests_high_and_is_brought_down_by_others_rests_high():
    values = faces(((0.0, 0.25), 400), ((0.8, 0.0), 250), ((0.4, 0.0), 250), ((0.0, 0.5), 100))
    assert resting_place(values) == pytest.approx([0.0, 0.25], abs=0.02)
    assert np.quantile(values[:, 1], 0.35) < 0.1


def test_who_smiles_more_often_than_not_does_not_rest_in_a_smile():
    values = faces(((0.1, 0.1), 300), ((0.8, 0.1), 700))
    assert resting_place(values) == pytest.approx([0.1, 0.1], abs=0.03)


def test_an_interval_counts_as_often_as_it_has_frames():
    values = faces(((0.1,), 2), ((0.3,), 20), sd=0.0)
    assert resting_place(values, np.repeat([300.0, 5.0], [2, 20])) == pytest.approx([0.1], abs=0.05)


def test_of_many_frames_some_do():
    values = faces(((0.1, 0.2), 50_000), ((0.6, 0.2), 20_000))
    assert resting_place(values) == pytest.approx([0.1, 0.2], abs=0.02)
    assert np.array_equal(resting_place(values), resting_place(values))


def test_few_clips_that_disagree_leave_the_resting_place_open():
    values = faces(((0.1,), 40), ((0.3,), 50), sd=0.01)
    few, many = np.arange(90) // 10, np.arange(90)
    clear = faces(((0.1,), 80), ((0.3,), 10), sd=0.01)

    def spread(values, clip):
        rng = np.random.default_rng(0)
        return resting_places(values, np.ones(90), clip, 300, rng).std()

    assert spread(values, few) > 2 * spread(clear, few)
    assert spread(values, few) > spread(clear, many)
