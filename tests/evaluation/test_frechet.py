import numpy as np
import pytest
from scipy.linalg import sqrtm

from mimeline.evaluation.frechet import frechet, gaussian_distances


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


def test_the_symmetric_form_gives_what_the_root_of_the_product_gives():
    mixing = np.random.default_rng(1).normal(size=(2, 4, 4))
    one, two = (draw([0.0] * 4, [1.0] * 4, n=300, seed=i) @ mixing[i] for i in (0, 1))
    covariances = np.cov(one, rowvar=False), np.cov(two, rowvar=False)
    apart = one.mean(axis=0) - two.mean(axis=0)
    product = sqrtm(covariances[0] @ covariances[1]).real
    expected = apart @ apart + np.trace(covariances[0] + covariances[1] - 2 * product)
    assert frechet(one, two) == pytest.approx(expected)


def test_a_channel_that_never_moves_does_no_harm():
    frames = draw([0.0, 0.0], [1.0, 0.0])
    assert frechet(frames, frames + np.array([0.0, 2.0])) == pytest.approx(4.0)


def test_a_single_frame_is_refused():
    with pytest.raises(ValueError, match="two samples"):
        frechet(np.zeros((1, 3)), np.zeros((9, 3)))


def test_a_pair_of_which_one_is_unknown_has_no_distance_and_spoils_no_other():
    means = np.array([[0.0, 0.0], [np.nan, np.nan], [3.0, 0.0]])
    covariances = np.broadcast_to(np.eye(2), (3, 2, 2))
    still = np.zeros((3, 2)), covariances
    found = gaussian_distances((means, covariances), still)
    assert found == pytest.approx([0.0, np.nan, 9.0], nan_ok=True)
