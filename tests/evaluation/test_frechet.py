import numpy as np
import pytest

from mimeline.evaluation.frechet import differences, frechet, motion_distances


def draw(mean, std, n=40_000, seed=0):
    return np.random.default_rng(seed).normal(mean, std, size=(n, len(mean)))


def test_a_set_is_at_no_distance_from_itself():
    frames = draw([0.0, 1.0, 2.0], [1.0, 2.0, 0.1], n=500)
    assert frechet(frames, frames) == pytest.approx(0.0, abs=1e-9)


def test_the_distance_of_gaussians_is_the_analytic_one():
    one, two = draw([0.0, 1.0], [1.0, 2.0]), draw([3.0, 1.0], [2.0, 0.5], seed=1)
    analytic = 3.0**2 + (1.0 - 2.0) ** 2 + (2.0 - 0.5) ** 2
    assert frechet(one, two) == pytest.approx(analytic, rel=0.02)
    assert frechet(one, two) == pytest.approx(frechet(two, one))


def test_correlation_counts():
    frames = draw([0.0, 0.0], [1.0, 1.0])
    tied = frames[:, :1].repeat(2, axis=1)  # trace of each covariance 2, of the overlap √2
    assert frechet(frames, tied) == pytest.approx(4 - 2 * np.sqrt(2), rel=0.02)


def test_a_channel_that_never_moves_does_no_harm():
    frames = draw([0.0, 0.0], [1.0, 0.0])
    assert frechet(frames, frames + np.array([0.0, 2.0])) == pytest.approx(4.0)


def test_a_single_frame_is_refused():
    with pytest.raises(ValueError, match="two samples"):
        frechet(np.zeros((1, 3)), np.zeros((9, 3)))


def test_differences_do_not_cross_clips():
    clips = [np.array([[0.0], [1.0], [3.0]]), np.array([[100.0], [101.0]])]
    assert differences(clips).ravel().tolist() == [1.0, 2.0, 1.0]


def test_motion_that_only_jitters_differs_in_velocity():
    smooth = [np.cumsum(clip, axis=0) for clip in draw([0.0], [0.1], n=400).reshape(4, 100, 1)]
    jittery = [np.random.default_rng(3).permuted(clip, axis=0) for clip in smooth]
    found = motion_distances(jittery, smooth)
    assert found["fid_fm"] == pytest.approx(0.0, abs=1e-9)
    assert found["fid_delta_fm"] > 0.01
    assert found["snd"] == found["fid_fm"] + found["fid_delta_fm"]
