"""TICC's alternation: estimate the clusters from labels, label the frames from the clusters."""

import logging
from dataclasses import dataclass

import numpy as np

from .likelihood import frame_costs
from .start import refill
from .statistics import cluster_statistics, cuts
from .toeplitz_lasso import Lasso, toeplitz_lasso
from .viterbi import best_path

log = logging.getLogger(__name__)

CHANGED = 1e-4  # share of frames that may still change cluster at convergence
REFILLS = 3  # times that a cluster which lost its frames is given new ones
FULL_WINDOWS = 2  # fewer, and a cluster counts as having lost its frames


RIDGE = 1e-6  # added to variances, so that sparsity = 0 and windows all alike stay bounded


@dataclass
class Fit:
    """The best that a descent came by.

    objective: nats, switches included · means (K, wn) · lasso: the precisions · labels (T,), the
    cheapest under these · iterations · converged.
    """

    objective: float
    means: np.ndarray
    lasso: Lasso
    labels: np.ndarray
    iterations: int
    converged: bool


def descend(X, lengths, labels, n_clusters, window, beta, sparsity, max_iter) -> Fit:
    """Alternate from labels (T,) until they settle or max_iter is reached.

    X (T, n), channels of unit variance · lengths (S,) · beta in nats. Labels and
    estimates lower the same penalised objective, but the windows that a border cuts are in the one
    and not in the other, so it may rise a little: the best iterate is returned, not the last
    (Hallac et al. 2017, algorithm 3).
    """
    full = ~cuts(lengths, window).any(axis=1)  # (T,)
    means = np.zeros((n_clusters, window * X.shape[1]))
    ridge = RIDGE * np.eye(means.shape[1])
    refills = np.zeros(n_clusters, np.int64)
    own = ((X - X.mean(axis=0)) ** 2).sum(axis=1)  # (T,) cost of a frame where it is
    covariances = np.tile(np.eye(means.shape[1]), (n_clusters, 1, 1))  # (K, wn, wn)
    lasso, best, converged = None, None, False
    for iteration in range(1, max_iter + 1):
        held = np.bincount(labels[full], minlength=n_clusters)
        empty = np.flatnonzero((held < FULL_WINDOWS) & (refills < REFILLS))
        if len(empty):
            labels = refill(labels, own, lengths, empty, window)
            refills[empty] += 1
        counts, *found = cluster_statistics(X, labels, full, n_clusters, window)
        alive = counts > 0  # a cluster without frames stays what it was
        means[alive], covariances[alive] = found[0][alive], found[1][alive] + ridge
        lasso = toeplitz_lasso(covariances, window, sparsity, lasso)
        costs = frame_costs(X, lengths, means, lasso.precisions, sparsity)
        old, (labels, objective) = labels, best_path(costs, lengths, float(beta))
        own = costs[np.arange(len(X)), labels]
        changed = int((labels != old).sum())
        log.debug("iteration %d: objective %.6g, %d frames changed", iteration, objective, changed)
        if best is None or objective < best.objective:
            best = Fit(objective, means.copy(), lasso, labels, iteration, False)
        if changed <= CHANGED * len(X):
            converged = True
            break
    best.iterations, best.converged = iteration, converged
    return best
