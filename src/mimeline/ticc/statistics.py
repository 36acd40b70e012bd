"""Sufficient statistics of a cluster: how many windows it holds, their mean, their covariance."""

import numpy as np
from numba import njit

from .toeplitz import from_lags, project_toeplitz
from .windows import Products, Windows, describe

CUT = -1  # label of a frame whose window is cut


def cluster_statistics(windows: Windows, labels, n_clusters: int):
    """Counts (K,), means (K, wn) and covariances (K, wn, wn) of each cluster's whole windows.

    labels (T,). A covariance is that of Hallac et al. 2017, eq. 3 (sum over windows / count) with
    each lag averaged over the window: tr(S P) for a block-Toeplitz P asks for no more, and so a
    window's (wn)^2 products are never formed. An empty cluster has count 0 and zeros.
    """
    n, window = windows.frames.n_channels, windows.reach.window
    products = Products.every(window, n)
    sums = np.zeros((n_clusters, 1 + window * n + len(products.lag)))
    for begin, end in windows.blocks():
        own = labels[begin:end].astype(np.int64)
        own[windows.cuts(begin, end)[0]] = CUT
        rows = describe(windows.values(begin, end), window, products)
        _add_runs(rows, own, sums)
    counts = np.rint(sums[:, 0]).astype(np.int64)
    sums /= np.maximum(counts, 1)[:, None]
    means = sums[:, 1 : 1 + window * n]  # (K, wn)
    lags = np.zeros((n_clusters, window, n, n))
    lags[:, products.lag, products.first, products.second] = sums[:, 1 + window * n :]
    lags[:, 0] += np.swapaxes(np.triu(lags[:, 0], 1), 1, 2)
    lags /= (window - np.arange(window))[:, None, None]
    square = np.einsum("ki,kj->kij", means, means)
    return counts, means, from_lags(lags) - project_toeplitz(square, window)


@njit(cache=True, fastmath={"reassoc"})  # a sum may be taken in vectors
def _add_runs(rows, labels, sums):
    ends, n_runs = np.empty(len(labels), np.int64), 0
    for t in range(len(labels)):
        if t == len(labels) - 1 or labels[t + 1] != labels[t]:
            ends[n_runs] = t + 1
            n_runs += 1
    for r in range(len(rows)):
        row, begin = rows[r], 0
        for end in ends[:n_runs]:
            k = labels[begin]
            if k != CUT:
                total = 0.0
                for t in range(begin, end):
                    total += row[t]
                sums[k, r] += total
            begin = end
