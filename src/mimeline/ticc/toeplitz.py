"""Block-Toeplitz matrices: every lag between two frames has one block, wherever it stands."""

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


def mean_lags(A: np.ndarray, window: int) -> np.ndarray:
    """(K, w, n, n): the mean of each block diagonal of symmetric A (K, wn, wn)."""
    n_clusters, size, _ = A.shape
    n = size // window
    blocks = A.reshape(n_clusters, window, n, window, n)
    lags = np.empty((n_clusters, window, n, n))
    for lag in range(window):
        rows = np.arange(window - lag)
        lags[:, lag] = blocks[:, rows, :, rows + lag, :].mean(axis=0)
    lags[:, 0] = (lags[:, 0] + np.swapaxes(lags[:, 0], 1, 2)) / 2
    return lags


def project_toeplitz(A: np.ndarray, window: int) -> np.ndarray:
    """The nearest symmetric block-Toeplitz matrices to symmetric A (K, wn, wn)."""
    return from_lags(mean_lags(A, window))
