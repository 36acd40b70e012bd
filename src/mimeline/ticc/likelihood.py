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
        self.partial, self.constants = [], []
        for front, back in [(0, 0), *windows.lacks]:
            P, logdet = marginal(precisions, front * n, size - back * n)
            number = size - (front + back) * n
            paid = penalty * np.abs(P).sum(axis=(1, 2))  # (K,)
            self.partial.append(P)
            self.constants.append(0.5 * (number * np.log(2 * np.pi) - logdet + paid))
        self.partial = np.array(self.partial[1:]).reshape(-1, *precisions.shape)  # (C, K, wn, wn)
        whole, *cut = self.constants
        self.constants = np.array(cut).reshape(-1, n_clusters)  # (C, K)

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


def marginal(precisions: np.ndarray, low: int, high: int) -> tuple[np.ndarray, np.ndarray]:
    """Precisions and log-determinants (K,) of the entries low to high of Gaussians.

    precisions (K, d, d). Returns (K, d, d), each marginal at its own rows and columns, zeros
    elsewhere. The marginal of a Gaussian drops rows of the covariance; in precisions that is a
    Schur complement.
    """
    size = precisions.shape[1]
    gone = np.r_[:low, high:size]
    rest = precisions[:, low:high, low:high]
    if len(gone):
        beside = precisions[:, gone, low:high]
        rest = rest - np.swapaxes(beside, 1, 2) @ np.linalg.solve(
            precisions[:, gone[:, None], gone], beside
        )
        rest = (rest + np.swapaxes(rest, 1, 2)) / 2
    whole = np.zeros_like(precisions)
    whole[:, low:high, low:high] = rest
    return whole, np.linalg.slogdet(rest)[1]
