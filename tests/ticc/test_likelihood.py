import numpy as np
import pytest
from scipy.stats import multivariate_normal

from mimeline.ticc.likelihood import frame_costs
from mimeline.ticc.statistics import cluster_statistics, cuts, reach
from mimeline.ticc.toeplitz_lasso import project_toeplitz


def clusters(n_clusters, window, n, seed=0):
    rng = np.random.default_rng(seed)
    noise = rng.normal(size=(n_clusters, window * n, window * n)) * 0.1
    P = project_toeplitz(noise + np.swapaxes(noise, 1, 2), window) + 2 * np.eye(window * n)
    assert np.linalg.eigvalsh(P).min() > 0
    return rng.normal(size=(n_clusters, window * n)), P


@pytest.mark.parametrize("window", [1, 2, 4, 5])
def test_costs_are_those_of_the_marginal_gaussian_of_what_a_window_sees(window):
    n, lengths = 2, np.array([9, 1, 2, 6])
    X = np.random.default_rng(1).normal(size=(lengths.sum(), n))
    means, P = clusters(3, window, n)
    costs = frame_costs(X, lengths, means, P)
    before, after = reach(window)
    starts = np.cumsum(lengths) - lengths
    for start, length in zip(starts, lengths, strict=True):
        for t in range(start, start + length):
            offsets = np.arange(-before, after + 1)
            inside = (t + offsets >= start) & (t + offsets < start + length)
            seen = X[t + offsets[inside]].ravel()
            kept = np.repeat(inside, n)
            for k in range(3):
                covariance = np.linalg.inv(P[k])[np.ix_(kept, kept)]
                expected = -multivariate_normal(means[k][kept], covariance).logpdf(seen)
                assert costs[t, k] == pytest.approx(expected)


def test_a_cost_includes_its_share_of_the_penalty_in_units_of_the_scale():
    X = np.random.default_rng(1).normal(size=(6, 2))
    means, P = clusters(3, 3, 2)
    scale = np.array([2.0, 0.5])
    bare, lengths = frame_costs(X, np.array([6]), means, P), np.array([6])
    found = frame_costs(X, lengths, means, P, sparsity=0.3, scale=scale) - bare
    units = np.tile(scale, 3)
    for k in range(3):
        whole = 0.15 * np.abs(units[:, None] * P[k] * units).sum()
        assert np.allclose(found[1:5, k], whole)
        seen = np.linalg.inv(np.linalg.inv(P[k])[2:, 2:])  # the first frame's window lacks one
        assert found[0, k] == pytest.approx(0.15 * np.abs(units[2:, None] * seen * units[2:]).sum())


def test_statistics_are_those_of_the_full_windows_and_never_straddle():
    window, lengths = 3, np.array([6, 2, 5])
    X = np.random.default_rng(2).normal(size=(13, 2))
    labels = np.array([0, 0, 1, 1, 0, 0, 1, 1, 0, 1, 1, 0, 0])
    full = ~cuts(lengths, window).any(axis=1)
    counts, means, covariances = cluster_statistics(X, labels, full, 3, window)
    centres = [1, 2, 3, 4, 9, 10, 11]
    assert np.flatnonzero(full).tolist() == centres
    for k in (0, 1):
        windows = np.array([X[t - 1 : t + 2].ravel() for t in centres if labels[t] == k])
        assert counts[k] == len(windows)
        assert np.allclose(means[k], windows.mean(axis=0))
        assert np.allclose(covariances[k], np.cov(windows, rowvar=False, bias=True))
    assert counts[2] == 0 and not covariances[2].any()
