"""Sufficient statistics of a cluster: how many windows it holds, their mean and their covariance.

A window is `window` consecutive frames of one sequence, oldest first, flattened; in a C-ordered
(T, n) array it is a slice of the flat buffer, so nothing is ever stacked.
"""

import numpy as np
from numba import njit


def reach(window: int) -> tuple[int, int]:
    """How many frames a frame's window holds before and after it.

    It is centred: where windows trail, labels come (w - 1) / 2 frames late at every switch.
    """
    after = window // 2
    return window - 1 - after, after


def cuts(lengths: np.ndarray, window: int) -> np.ndarray:
    """(T, 2) int64: how many frames each frame's window lacks at its front and at its back.

    A window never reaches over the border of its sequence, so it is cut there.
    """
    before, after = reach(window)
    ends = np.repeat(np.cumsum(lengths), lengths)  # (T,) the sequence ends before this frame
    starts = ends - np.repeat(lengths, lengths)  # (T,) its first frame
    frame = np.arange(len(ends))
    front = np.maximum(before - (frame - starts), 0)
    back = np.maximum(after - (ends - 1 - frame), 0)
    return np.stack([front, back], axis=1)  # (T, 2)


def cluster_statistics(X, labels, full, n_clusters: int, window: int):
    """Counts (K,), means (K, wn) and covariances (K, wn, wn) of each cluster's full windows.

    X (T, n) float64, C order · labels (T,) · full (T,) bool, the frames whose window is not cut.
    Covariances are the biased ones, sum over windows / count, as the
    likelihood asks for (Hallac et al. 2017, eq. 3). An empty cluster has count 0 and zeros.
    """
    n = X.shape[1]
    first = (np.flatnonzero(full) - reach(window)[0]) * n  # where the windows begin in the buffer
    counts, means = _means(X.ravel(), first, labels[full], n_clusters, window * n)
    covariances = _covariances(X.ravel(), first, labels[full], means)
    covariances /= np.maximum(counts, 1)[:, None, None]
    lower = np.tril(covariances)  # (K, wn, wn)
    return counts, means, lower + np.swapaxes(np.tril(covariances, -1), 1, 2)


@njit(cache=True)
def _means(flat, first, labels, n_clusters, size):
    counts = np.zeros(n_clusters, np.int64)
    means = np.zeros((n_clusters, size))
    for t in range(len(labels)):
        k = labels[t]
        counts[k] += 1
        for i in range(size):
            means[k, i] += flat[first[t] + i]
    for k in range(n_clusters):
        if counts[k]:
            means[k] /= counts[k]
    return counts, means


@njit(cache=True)
def _covariances(flat, first, labels, means):
    n_clusters, size = means.shape
    scatter = np.zeros((n_clusters, size, size))  # lower triangles
    deviation = np.empty(size)
    for t in range(len(labels)):
        k = labels[t]
        for i in range(size):
            deviation[i] = flat[first[t] + i] - means[k, i]
        for i in range(size):
            for j in range(i + 1):
                scatter[k, i, j] += deviation[i] * deviation[j]
    return scatter
