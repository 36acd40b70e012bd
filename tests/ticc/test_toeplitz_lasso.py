import numpy as np
import pytest
from sklearn.covariance import graphical_lasso

from mimeline.ticc.toeplitz import project_toeplitz
from mimeline.ticc.toeplitz_lasso import toeplitz_lasso


def covariances(n_clusters, size, seed=0):
    rng = np.random.default_rng(seed)
    mixing = rng.normal(size=(n_clusters, size, size)) / np.sqrt(size)
    samples = rng.normal(size=(n_clusters, 300, size)) @ mixing
    return np.stack([np.cov(s, rowvar=False, bias=True) for s in samples])


def test_solutions_are_block_toeplitz_positive_definite_and_sparse():
    window, n = 4, 3
    P = toeplitz_lasso(covariances(5, window * n), window, 0.1).precisions
    blocks = P.reshape(5, window, n, window, n)
    for lag in range(window):
        for i in range(1, window - lag):
            assert np.array_equal(blocks[:, i, :, i + lag], blocks[:, 0, :, lag])
    assert np.array_equal(P, np.swapaxes(P, 1, 2))
    assert np.linalg.eigvalsh(P).min() > 0
    assert (P == 0).any()


@pytest.mark.parametrize("sparsity", [0.01, 0.1, 0.5])
def test_solutions_are_stationary(sparsity):
    """The gradient, averaged over each block diagonal, is a subgradient of the penalty."""
    window = 3
    S = covariances(4, 9, seed=1)
    P = toeplitz_lasso(S, window, sparsity, tol=1e-8, max_iter=20_000).precisions
    slope = project_toeplitz(np.linalg.inv(P) - S, window)
    assert np.abs(slope).max() <= sparsity + 1e-5
    assert np.allclose(slope[P != 0], sparsity * np.sign(P[P != 0]), atol=1e-5)


def test_with_windows_of_one_frame_it_is_the_graphical_lasso():
    (S,) = covariances(1, 5, seed=2)
    sparsity = 0.08
    found = toeplitz_lasso(S[None], 1, sparsity, tol=1e-8).precisions[0]
    inflated = S + sparsity * np.eye(5)  # the peer leaves the diagonal free of the penalty
    _, expected = graphical_lasso(inflated, sparsity)
    assert np.allclose(found, expected, atol=2e-3)
    assert np.array_equal(found == 0, expected == 0)


def test_a_cluster_that_never_moves_has_a_bounded_precision():
    P = toeplitz_lasso(np.zeros((1, 6, 6)), 2, 0.11).precisions[0]
    assert np.allclose(P, np.eye(6) / 0.11, rtol=1e-3)


def test_what_stops_early_is_positive_definite_all_the_same():
    rng = np.random.default_rng(0)
    smooth = np.cumsum(rng.normal(size=(400, 12)), axis=1)  # near singular
    S = np.cov(smooth, rowvar=False)[None]
    for steps in range(1, 12):
        P = toeplitz_lasso(S, 4, 1e-4, max_iter=steps).precisions
        assert np.linalg.eigvalsh(P).min() > 0


def test_clusters_do_not_touch_each_other():
    S = covariances(4, 6, seed=3)
    together = toeplitz_lasso(S, 2, 0.1).precisions
    for k in range(4):
        assert np.allclose(together[k], toeplitz_lasso(S[k : k + 1], 2, 0.1).precisions[0])


def test_a_warm_start_comes_to_the_same_solution_sooner():
    S = covariances(3, 8, seed=4)
    cold = toeplitz_lasso(S, 4, 0.05)
    nudged = S + 1e-3 * np.eye(8)
    warm = toeplitz_lasso(nudged, 4, 0.05, cold)
    fresh = toeplitz_lasso(nudged, 4, 0.05)
    assert np.allclose(warm.precisions, fresh.precisions, rtol=1e-3, atol=1e-3)
    assert warm.iterations.sum() < fresh.iterations.sum()
