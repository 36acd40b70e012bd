"""What a frame costs in a cluster: the negative log-likelihood of the window around it."""

from dataclasses import dataclass

import numpy as np
from numba import njit

from .windows import Products, Windows, describe


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

    def __init__(self, gaussians: Gaussians, windows: Windows, penalty: float = 0.0):
        means, precisions = gaussians.means, gaussians.precisions
        n_clusters, size = means.shape
        self.windows, self.window, self.means = windows, windows.reach.window, means
        n = size // self.window
        self.partial = np.empty((len(windows.lacks), *precisions.shape))  # (C, K, wn, wn)
        self.constants = np.empty((len(windows.lacks), n_clusters))
        for kind, (front, back) in enumerate(windows.lacks):
            self.partial[kind], logdets = marginal(precisions, front * n, size - back * n)
            number = size - (front + back) * n
            self.constants[kind] = _constant(number, logdets, self.partial[kind], penalty)
        whole = _constant(size, np.linalg.slogdet(precisions)[1], precisions, penalty)  # (K,)

        lags = np.swapaxes(precisions[:, :n].reshape(n_clusters, n, self.window, n), 1, 2)
        self.products = Products.of((lags != 0).any(axis=0))
        lag, first, second = self.products.lag, self.products.first, self.products.second
        once = (lag == 0) & (first == second)  # any other product stands twice in the square
        linear = np.einsum("kij,kj->ki", precisions, means)  # (K, wn)
        least = whole + 0.5 * np.einsum("ki,ki->k", linear, means)  # (K,)
        squares = np.where(once, 0.5, 1.0) * lags[:, lag, first, second]  # (K, F)
        self.weights = np.concatenate([least[:, None], -linear, squares], axis=1).T  # (R, K)

    def of(self, begin: int, end: int) -> np.ndarray:
        """(end - begin, K): the costs of frames begin to end in each cluster."""
        values = self.windows.values(begin, end)
        costs = describe(values, self.window, self.products).T @ self.weights
        at, kind = self.windows.cuts(begin, end)
        if len(at):
            lacks = self.windows.lacks
            _cut_costs(values, at, kind, lacks, self.means, self.partial, self.constants, costs)
        return costs

    def own(self, labels: np.ndarray) -> np.ndarray:
        """(T,): the cost of each frame in the cluster that labels (T,) give it."""
        own = np.empty(len(labels))
        for begin, end in self.windows.blocks():
            block = self.of(begin, end)
            own[begin:end] = block[np.arange(end - begin), labels[begin:end]]
        return own


@njit(cache=True)
def _cut_costs(values, at, kinds, lacks, means, partial, constants, costs):
    n = len(values)
    n_clusters, size = means.shape
    seen, deviation = np.empty(size), np.empty(size)
    for t, kind in zip(at, kinds):  # noqa: B905
        low, high = lacks[kind, 0] * n, size - lacks[kind, 1] * n
        for i in range(low, high):
            seen[i] = values[i % n, t + i // n]
        for k in range(n_clusters):
            P = partial[kind, k]
            square = 0.0
            for i in range(low, high):  # row by row of the lower triangle
                deviation[i] = seen[i] - means[k, i]
                product = 0.0
                for j in range(low, i):
                    product += P[i, j] * deviation[j]
                square += (2 * product + P[i, i] * deviation[i]) * deviation[i]
            costs[t, k] = 0.5 * square + constants[kind, k]


def _constant(number: int, logdets, precisions, penalty: float) -> np.ndarray:
    """(K,): what a window of so many numbers costs wherever its frames lie."""
    paid = penalty * np.abs(precisions).sum(axis=(1, 2))
    return 0.5 * (number * np.log(2 * np.pi) - logdets + paid)


def marginal(precisions: np.ndarray, low: int, high: int) -> tuple[np.ndarray, np.ndarray]:
    """Precisions and log-determinants (K,) of the entries low to high of Gaussians.

    precisions (K, d, d). Returns (K, d, d), each marginal at its own rows and columns, zeros
    elsewhere. The marginal of a Gaussian drops rows of the covariance; in precisions that is a
    Schur complement.
    """
    size = precisions.shape[1]
    gone = np.r_[:low, high:size]
    beside = precisions[:, gone, low:high]
    inside = np.linalg.solve(precisions[:, gone[:, None], gone], beside)
    rest = precisions[:, low:high, low:high] - np.swapaxes(beside, 1, 2) @ inside
    rest = (rest + np.swapaxes(rest, 1, 2)) / 2
    whole = np.zeros_like(precisions)
    whole[:, low:high, low:high] = rest
    return whole, np.linalg.slogdet(rest)[1]
