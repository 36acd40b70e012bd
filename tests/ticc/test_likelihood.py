import numpy as np
import pytest
from scipy.stats import multivariate_normal

from mimeline.ticc.likelihood import Costs, Gaussians
from mimeline.ticc.toeplitz import project_toeplitz
from mimeline.ticc.windows import centred, trailing


def gaussians(n_clusters, window, n, seed=0):
    rng = np.random.default_rng(seed)
    noise = rng.normal(size=(n_clusters, window * n, window * n)) * 0.1
    P = project_toeplitz(noise + np.swapaxes(noise, 1, 2), window) + 2 * np.eye(window * n)
    P[:, 0, n:] = P[:, n:, 0] = 0  # below, only what is held is asked for
    P = project_toeplitz(P, window)
    assert np.linalg.eigvalsh(P).min() > 0
    return Gaussians(rng.normal(size=(n_clusters, window * n)), P)


def expected_cost(X, t, borders, reach, mean, P):
    begin, end = borders
    offsets = np.arange(-reach.before, reach.after + 1)
    inside = (t + offsets >= begin) & (t + offsets < end)
    kept = np.repeat(inside, X.shape[1])
    covariance = np.linalg.inv(P)[np.ix_(kept, kept)]
    return -multivariate_normal(mean[kept], covariance).logpdf(X[t + offsets[inside]].ravel())


@pytest.mark.parametrize("reach", [centred(1), centred(2), centred(4), centred(5), trailing(4)])
def test_costs_are_those_of_the_marginal_gaussian_of_what_a_window_sees(reach, windows_of):
    n, lengths = 2, np.array([9, 1, 2, 6])
    X = np.random.default_rng(1).normal(size=(lengths.sum(), n))
    clusters = gaussians(3, reach.window, n)
    windows = windows_of(X, lengths, reach.window, reach)
    costs = Costs(clusters, windows).of(0, len(X))
    ends = np.cumsum(lengths)
    for begin, end in zip(ends - lengths, ends, strict=True):
        for t in range(begin, end):
            for k in range(3):
                expected = expected_cost(
                    X, t, (begin, end), reach, clusters.means[k], clusters.precisions[k]
                )
                assert costs[t, k] == pytest.approx(expected)


def test_a_block_costs_what_it_costs_among_others(windows_of):
    lengths = np.array([40, 3, 50])
    X = np.random.default_rng(1).normal(size=(93, 2))
    windows = windows_of(X, lengths, 5)
    costs = Costs(gaussians(3, 5, 2), windows)
    whole = costs.of(0, 93)
    for begin, end in ((0, 7), (38, 44), (60, 93)):
        assert np.allclose(costs.of(begin, end), whole[begin:end], rtol=1e-12)


def test_a_cost_includes_its_share_of_the_penalty(windows_of):
    X = np.random.default_rng(1).normal(size=(6, 2))
    clusters, windows = gaussians(3, 3, 2), windows_of(X, [6], 3)
    bare = Costs(clusters, windows).of(0, 6)
    found = Costs(clusters, windows, penalty=0.3).of(0, 6) - bare
    for k, P in enumerate(clusters.precisions):
        assert np.allclose(found[1:5, k], 0.15 * np.abs(P).sum())
        seen = np.linalg.inv(np.linalg.inv(P)[2:, 2:])  # the first frame's window lacks one
        assert found[0, k] == pytest.approx(0.15 * np.abs(seen).sum())
