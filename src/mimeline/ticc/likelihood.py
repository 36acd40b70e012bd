"""What a frame costs in a cluster: the negative log-likelihood of the window around it."""

import numpy as np
from numba import njit

from .statistics import cuts, reach


def marginals(precisions: np.ndarray, window: int) -> tuple[np.ndarray, np.ndarray]:
    """Precisions and log-determinants of what is left of each cluster's window at a border.

    precisions (K, wn, wn). Returns (before + 1, after + 1, K, wn, wn), indexed by the frames that
    lack at the front and at the back, each marginal at its own rows and columns (zeros elsewhere),
    and (before + 1, after + 1, K). The marginal of a Gaussian drops rows of the covariance; in
    precisions that is a Schur complement, taken here a frame at a time.
    """
    n_clusters, size, _ = precisions.shape
    n, (before, after) = size // window, reach(window)
    partial = np.zeros((before + 1, after + 1, *precisions.shape))
    logdets = np.empty((before + 1, after + 1, n_clusters))
    for front in range(before + 1):
        for back in range(after + 1):
            kept = slice(front * n, size - back * n)
            if not front and not back:
                partial[0, 0] = precisions
            elif back:
                gone = slice(size - back * n, size - (back - 1) * n)
                partial[front, back, :, kept, kept] = _schur(partial[front, back - 1], kept, gone)
            else:
                gone = slice((front - 1) * n, front * n)
                partial[front, 0, :, kept, kept] = _schur(partial[front - 1, 0], kept, gone)
            logdets[front, back] = np.linalg.slogdet(partial[front, back, :, kept, kept])[1]
    return partial, logdets


def _schur(P, kept, gone):
    inside = np.linalg.solve(P[:, gone, gone], P[:, gone, kept])  # (K, n, kept)
    rest = P[:, kept, kept] - P[:, kept, gone] @ inside  # (K, kept, kept)
    return (rest + np.swapaxes(rest, 1, 2)) / 2


def frame_costs(X, lengths, means, precisions, sparsity=0.0, scale=1.0) -> np.ndarray:
    """(T, K): the negative log-likelihood of each frame's window in each cluster, in nats.

    X (T, n) float64 · lengths (S,) · means (K, wn) · precisions (K, wn, wn).
    1/2 (x - m)' P (x - m) - 1/2 log det P + wn/2 log 2 pi (Hallac et al. 2017, eq. 3). A window
    that would reach over a border is cut there and scored by the exact marginal.

    sparsity: adds sparsity / 2 * sum |P_ij| in units of scale (n,), a frame's share of the penalty
    that the estimates pay; labels and estimates then lower one objective.
    """
    n = X.shape[1]
    window = means.shape[1] // n
    partial, logdets = marginals(precisions, window)
    front, back = np.indices(logdets.shape[:2])
    numbers = (window - front - back)[..., None] * n  # (before + 1, after + 1, 1)
    units = np.tile(np.broadcast_to(scale, n), window)  # (wn,)
    penalties = sparsity * (units @ np.abs(partial) @ units)  # (before + 1, after + 1, K)
    constants = 0.5 * (numbers * np.log(2 * np.pi) - logdets + penalties)
    flat = np.ascontiguousarray(X, dtype=np.float64).ravel()
    return _costs(flat, n, reach(window)[0], cuts(lengths, window), means, partial, constants)


@njit(cache=True)
def _costs(flat, n, before, lacking, means, partial, constants):
    n_clusters, size = means.shape
    costs = np.empty((len(lacking), n_clusters))
    deviation, product = np.empty(size), np.empty(size)
    for t in range(len(lacking)):
        front, back = lacking[t]
        begin = (t - before) * n  # where the window lies in the buffer
        for k in range(n_clusters):
            deviation[:] = 0.0
            product[:] = 0.0
            for i in range(front * n, size - back * n):
                deviation[i] = flat[begin + i] - means[k, i]
            P = partial[front, back, k]
            for i in range(size):  # row by row, so that the inner loop runs on vectors
                for j in range(size):
                    product[j] += P[i, j] * deviation[i]
            square = 0.0
            for i in range(size):
                square += product[i] * deviation[i]
            costs[t, k] = 0.5 * square + constants[front, back, k]
    return costs
