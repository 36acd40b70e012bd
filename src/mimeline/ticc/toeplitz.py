"""Block-Toeplitz matrices: every lag between two frames has one block, wherever it stands."""

from functools import lru_cache

import numpy as np


def from_lags(lags: np.ndarray) -> np.ndarray:
    """The symmetric block-Toeplitz matrices (K, wn, wn) of lags (K, w, n, n).

    Block (a, a + lag) is lags[:, lag]; lags[:, 0] is symmetric.
    """
    n_clusters, window, n, _ = lags.shape
    blocks = np.empty((n_clusters, window, n, window, n))
    for lag in range(window):
        rows = np.arange(window - lag)
        blocks[:, rows, :, rows + lag, :] = lags[:, lag]
        blocks[:, rows + lag, :, rows, :] = np.swapaxes(lags[:, lag], 1, 2)
    return blocks.reshape(n_clusters, window * n, window * n)


def project_toeplitz(A: np.ndarray, window: int) -> np.ndarray:
    """The nearest symmetric block-Toeplitz matrices to symmetric A (K, wn, wn).

    Entries that stand for one lag and pair of channels become their mean.
    """
    group, order, starts, counts = _groups(window, A.shape[1] // window)
    flat = A.reshape(len(A), -1)
    means = np.add.reduceat(flat[:, order], starts, axis=1) / counts  # (K, groups)
    return means[:, group].reshape(A.shape)


@lru_cache(maxsize=16)
def _groups(window: int, n: int):
    """The group of each entry (wn wn,), entries by group, where each begins there, their counts."""
    frame, channel = np.divmod(np.arange(window * n), n)
    lag = frame - frame[:, None]  # (wn, wn)
    later = lag > 0
    pair = np.where(later, channel[:, None] * n + channel, channel * n + channel[:, None])
    within = np.minimum.outer(channel, channel) * n + np.maximum.outer(channel, channel)
    pair = np.where(lag == 0, within, pair)
    group = np.unique(np.abs(lag) * n * n + pair, return_inverse=True)[1].ravel()
    counts = np.bincount(group)
    return group, np.argsort(group, kind="stable"), np.cumsum(counts) - counts, counts
