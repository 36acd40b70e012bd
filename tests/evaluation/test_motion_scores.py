import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mimeline.annotation.scores import resampled
from mimeline.evaluation.frechet import frechet
from mimeline.evaluation.motion_scores import (
    Moments,
    alignment_draws,
    from_zero,
    liveliness_draws,
    motion_draws,
    spread,
)

NOTHING = np.zeros((0, 3))


def clips(n, seed, scale=1.0):
    """Clips of one or two stretches of a random walk, of different lengths."""
    rng = np.random.default_rng(seed)
    lengths = rng.integers(8, 20, size=(n, 2))
    walks = [[rng.normal(0, scale, (length, 3)) for length in own] for own in lengths]
    return [[np.cumsum(walk, axis=0) for walk in own[: 1 + i % 2]] for i, own in enumerate(walks)]


def frames(chosen):
    return np.concatenate([stretch for clip in chosen for stretch in clip])


def changes(chosen, order=1):
    return np.concatenate([np.diff(stretch, order, axis=0) for clip in chosen for stretch in clip])


def once(n):
    return np.ones((1, n))


@settings(max_examples=15, deadline=None)
@given(st.lists(st.integers(0, 3), min_size=4, max_size=4).filter(any))
def test_a_weighed_score_is_that_of_the_clips_taken_so_often(times):
    made, real = clips(4, 0), clips(4, 1)
    weights = np.array([times], dtype=float)
    found = motion_draws(Moments.of(made), Moments.of(real), weights)
    found |= liveliness_draws(Moments.of(made), weights)
    taken, other = (
        [c for c, n in zip(own, times, strict=True) for _ in range(n)] for own in (made, real)
    )
    sizes = {n: [np.abs(changes(own, n)).mean() for own in (taken, other)] for n in (1, 3)}
    expected = {
        "fid_fm": frechet(frames(taken), frames(other)),
        "fid_delta_fm": frechet(changes(taken), changes(other)),
        "velocity_ratio": sizes[1][0] / sizes[1][1],
        "jerk_ratio": sizes[3][0] / sizes[3][1],
        "var": frames(taken).var(axis=0).mean(),
        "velocity": sizes[1][0],
        "jerk": sizes[3][0],
    }
    expected["snd"] = expected["fid_fm"] + expected["fid_delta_fm"]
    assert {name: own[0] for name, own in found.items()} == pytest.approx(expected)


def test_motion_of_twice_the_size_is_twice_as_quick_and_as_jerky():
    real = clips(5, 0)
    doubled = [[2 * stretch for stretch in clip] for clip in real]
    found = motion_draws(Moments.of(doubled), Moments.of(real), resampled(5, 20, draws(0)))
    assert found["velocity_ratio"] == pytest.approx(2.0)  # in every resample: clips go in pairs
    assert found["jerk_ratio"] == pytest.approx(2.0)


def draws(seed):
    return np.random.default_rng(seed)


def test_jerk_is_the_third_difference_and_is_nought_for_a_parabola():
    t = np.arange(9.0)[:, None]
    found = liveliness_draws(Moments.of([[t**2], [t**3]]), np.array([[1.0, 0.0], [0.0, 1.0]]))
    assert found["jerk"] == pytest.approx([0.0, 6.0])
    assert found["velocity"][0] == pytest.approx(8.0)  # 64 in 8 changes


def test_motion_that_only_jitters_differs_in_velocity():
    smooth = clips(4, 2)
    jittery = [[draws(3).permutation(stretch) for stretch in clip] for clip in smooth]
    found = motion_draws(Moments.of(jittery), Moments.of(smooth), once(4))
    assert found["fid_fm"][0] == pytest.approx(0.0, abs=1e-6)
    assert found["fid_delta_fm"][0] > 1
    assert found["velocity_ratio"][0] > 1


def test_an_interval_lies_about_the_value_although_resamples_are_further_apart():
    made, real = Moments.of(clips(8, 0)), Moments.of(clips(8, 1))
    found = motion_draws(made, real, resampled(8, 200, draws(0)))["fid_fm"]
    value, low, high = spread(found)
    assert np.mean(found[1:]) > value == found[0]
    assert high - value == pytest.approx(value - low) == pytest.approx(1.96 * found[1:].std(ddof=1))
    assert from_zero(found) == (value, max(low, 0.0), high)


def test_a_score_that_cannot_fall_below_nought_has_no_interval_that_does():
    assert from_zero(np.array([1.0, 0.0, 9.0]))[1] == 0.0
    assert spread(np.array([1.0, 0.0, 9.0]))[1] < 0


def test_one_clip_has_scores_and_no_intervals():
    made, real = Moments.of(clips(1, 0)), Moments.of(clips(1, 1))
    weights = resampled(1, 50, draws(0))
    scores = motion_draws(made, real, weights) | liveliness_draws(made, weights)
    for value, low, high in map(from_zero, scores.values()):
        assert np.isfinite(value)
        assert np.isnan([low, high]).all()


def test_clips_of_which_nothing_is_known_count_nothing():
    made, real = clips(4, 0), clips(4, 1)
    holed = [*real[:2], [NOTHING], [NOTHING]]
    found = motion_draws(Moments.of(made), Moments.of(holed), once(4))
    expected = motion_draws(Moments.of(made), Moments.of(real[:2]), once(4), once(2))
    assert {k: v[0] for k, v in found.items()} == pytest.approx(
        {k: v[0] for k, v in expected.items()}
    )


def test_where_no_real_clip_is_known_there_is_no_distance_and_no_ratio():
    found = motion_draws(Moments.of(clips(3, 0)), Moments.of([[NOTHING]] * 3), once(3))
    assert all(np.isnan(own).all() for own in found.values())


def test_a_resample_without_known_clips_does_not_count_in_the_interval():
    real = Moments.of([*clips(1, 1), [NOTHING]])
    weights = np.array([[1.0, 1.0], [0.0, 2.0], [2.0, 0.0], [1.0, 1.0]])
    found = motion_draws(Moments.of(clips(2, 0)), real, weights)["snd"]
    assert np.isnan(found).tolist() == [False, True, False, False]
    assert np.isfinite(spread(found)).all()


def test_alignment_is_the_mean_of_the_regions_of_which_an_action_was_asked():
    brow = np.array([[[4, 0, 0], [4, 0, 0], [0, 0, 0]]])  # asked for 4 frames, never found
    mouth = np.array([[[4, 0], [0, 4]]])
    gaze = np.array([[[8, 0, 0], [0, 0, 0], [0, 0, 0]]])  # never asked for
    found = alignment_draws({"brow": brow, "mouth": mouth, "gaze_h": gaze}, once(1))
    assert found["tas_mouth"] == 1.0
    assert found["tas_brow"] == pytest.approx(8 / 12 / 2)
    assert found["tas"] == pytest.approx((1.0 + 8 / 12 / 2) / 2)
    assert found["tas_gaze"] == 1.0
    assert alignment_draws({}, once(1)) == {}
