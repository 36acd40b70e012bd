"""What a frame costs in a cluster: the negative log-likelihood of the window around it."""

from dataclasses import dataclass

import numpy as np
from numba import njit

from .windows import Products, Reach, Windows, describe


@dataclass(frozen=True)
class Gaussians:
    """Clusters as Gaussians of windows. means (K, wn), precisions (K, wn, wn) block-Toeplitz."""

    means: np.ndarray
    precisions: np.ndarray

    def __len__(self) -> int:
        return len(self.means)


class Costs:
    """Costs of frames, nats: 1/2 (x - m)' P (x - m) - 1/2 log det P + wn/2 log 2 pi.

    Source: Hallac et al. 2017, eq. 3. A window that a border cuts is scored by the exact marginal
    of what it sees. penalty: adds penalty / 2 * sum |P_ij|, a window's share of what the estimates
    pay for their precisions; labels and estimates then lower one objective.

    For a block-Toeplitz P the square is a weighted sum of a window's products, as many as P holds
    lags and pairs of channels that are not zero in all clusters, and of the window's own frames.
    """

    def __init__(self, gaussians: Gaussians, reach: Reach, penalty: float = 0.0):
        means, precisions = gaussians.means, gaussians.precisions
        n_clusters, size = means.shape
        self.window = reach.window
        self.means = means
        n = size // self.window
        self.partial, logdets = marginals(precisions, reach)
        front, back = np.indices(logdets.shape[:2])
        numbers = ((self.window - front - back) * n)[..., None]  # (before + 1, after + 1, 1)
        penalties = penalty * np.abs(self.partial).sum(axis=(-2, -1))  # (.., .., K)
        self.constants = 0.5 * (numbers * np.log(2 * np.pi) - logdets + penalties)

        lags = np.swapaxes(precisions[:, :n].reshape(n_clusters, n, self.window, n), 1, 2)
        self.products = Products.of((lags != 0).any(axis=0))
        lag, first, second = self.products.lag, self.products.first, self.products.second
        once = (lag == 0) & (first == second)  # any other product stands twice in the square
        linear = np.einsum("kij,kj->ki", precisions, means)  # (K, wn)
        least = self.constants[0, 0] + 0.5 * np.einsum("ki,ki->k", linear, means)  # (K,)
        squares = np.where(once, 0.5, 1.0) * lags[:, lag, first, second]  # (K, F)
        self.weights = np.concatenate([least[:, None], -linear, squares], axis=1).T  # (R, K)

    def of(self, windows: Windows, begin: int, end: int) -> np.ndarray:
        """(end - begin, K): the costs of frames begin to end in each cluster."""
        values = windows.values(begin, end)
        costs = describe(values, self.window, self.products).T @ self.weights
        at, lacks = windows.cuts(begin, end)
        if len(at):
            _cut_costs(values, at, lacks, self.means, self.partial, self.constants, costs)
        return costs


@njit(cache=True)
def _cut_costs(values, at, lacks, means, partial, constants, costs):
    n = len(values)
    n_clusters, size = means.shape
    seen, deviation = np.empty(size), np.empty(size)
    for t, (front, back) in zip(at, lacks):  # noqa: B905
        low, high = front * n, size - back * n
        for i in range(low, high):
            seen[i] = values[i % n, t + i // n]
        for k in range(n_clusters):
            P = partial[front, back, k]
            square = 0.0
            for i in range(low, high):  # row by row of the lower triangle
                deviation[i] = seen[i] - means[k, i]
                product = 0.0
                for j in range(low, i):
                    product += P[i, j] * deviation[j]
                square += (2 * product + P[i, i] * deviation[i]) * deviation[i]
            costs[t, k] = 0.5 * square + constants[front, back, k]


def marginals(precisions: np.ndarray, reach: Reach) -> tuple[np.ndarray, np.ndarray]:
    """Precisions and log-determinants of what is left of each cluster's window at a border.

    precisions (K, wn, wn). Returns (before + 1, after + 1, K, wn, wn), indexed by the frames that
    lack at the front and at the back, each marginal at its own rows and columns (zeros elsewhere),
    and (before + 1, after + 1, K). The marginal of a Gaussian drops rows of the covariance; in
    precisions that is a Schur complement, taken here a frame at a time.
    """
    n_clusters, size, _ = precisions.shape
    n = size // reach.window
    partial = np.zeros((reach.before + 1, reach.after + 1, *precisions.shape))
    logdets = np.empty((reach.before + 1, reach.after + 1, n_clusters))
    for front in range(reach.before + 1):
        for back in range(reach.after + 1):
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
