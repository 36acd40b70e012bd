import numpy as np
import pytest

from mimeline.ticc.statistics import cluster_statistics
from mimeline.ticc.toeplitz import project_toeplitz
from mimeline.ticc.windows import BLOCK, centred, trailing


@pytest.mark.parametrize("reach", [centred(3), trailing(3), centred(1), centred(6)])
def test_statistics_are_those_of_the_whole_windows_and_never_straddle(reach, windows_of):
    rng = np.random.default_rng(2)
    lengths = np.array([6, 2, 5, 2 * BLOCK, 30])
    X = rng.normal(size=(lengths.sum(), 2)) + 3.0
    labels = np.repeat(rng.integers(2, size=len(X)), 4)[: len(X)]
    counts, means, covariances = cluster_statistics(
        windows_of(X, lengths, reach.window, reach), labels, 3
    )
    ends = np.cumsum(lengths)
    seen = {0: [], 1: []}
    for begin, end in zip(ends - lengths, ends, strict=True):
        for t in range(begin + reach.before, end - reach.after):
            seen[labels[t]].append(X[t - reach.before : t + reach.after + 1].ravel())
    for k, windows in seen.items():
        assert counts[k] == len(windows)
        assert np.allclose(means[k], np.mean(windows, axis=0))
        exact = np.cov(windows, rowvar=False, bias=True)
        assert np.allclose(covariances[k], project_toeplitz(exact[None], reach.window)[0])
    assert counts[2] == 0 and not covariances[2].any()
