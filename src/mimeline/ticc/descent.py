"""TICC's alternation: estimate the clusters from labels, label the frames from the clusters."""

import logging
import time
from dataclasses import dataclass

import numpy as np

from .likelihood import Costs, Gaussians
from .start import refill
from .statistics import cluster_statistics
from .toeplitz_lasso import toeplitz_lasso
from .viterbi import Trellis
from .windows import Windows

log = logging.getLogger(__name__)

CHANGED = 1e-4  # share of frames that may still change cluster at convergence
REFILLS = 3  # times that a cluster which lost its frames is given new ones
FULL_WINDOWS = 2  # fewer, and a cluster counts as having lost its frames
SLOW_S = 5.0  # an iteration that takes longer is told of
RIDGE = 1e-6  # added to variances, so that sparsity = 0 and windows all alike stay bounded


@dataclass(frozen=True)
class Setting:
    """What a descent is asked for: K, the price of a switch, the l1 weight, the most iterations.

    penalised: whether labels pay their share of the l1 penalty, as the estimates do; one objective
    falls then, but for the windows that a border cuts, which labels see and estimates do not.
    """

    n_clusters: int
    beta: float
    sparsity: float
    max_iter: int
    penalised: bool


@dataclass
class Fit:
    """What a descent came to.

    objective: nats, switches included · gaussians · labels (T,), the cheapest under these ·
    iterations · converged.
    """

    objective: float
    gaussians: Gaussians
    labels: np.ndarray
    iterations: int
    converged: bool


def trellis(windows: Windows, gaussians: Gaussians, setting: Setting) -> Trellis:
    """The cheapest labels of the windows' frames."""
    costs = Costs(gaussians, windows, setting.sparsity if setting.penalised else 0.0)
    return Trellis(costs.of, windows.blocks(), windows.opens, len(gaussians), setting.beta)


def descend(windows: Windows, labels, setting: Setting) -> Fit:
    """Alternate from labels (T,) until they settle or max_iter is reached.

    Source: Hallac et al. 2017, algorithm 3.
    """
    size = windows.reach.window * windows.frames.n_channels
    means = np.zeros((setting.n_clusters, size))
    covariances = np.tile(np.eye(size), (setting.n_clusters, 1, 1))  # (K, wn, wn)
    ridge = RIDGE * np.eye(size)
    refills = np.zeros(setting.n_clusters, dtype=np.int64)
    lasso, fit = None, None
    for iteration in range(1, setting.max_iter + 1):
        began = time.monotonic()
        held = np.bincount(labels, minlength=setting.n_clusters)
        held -= np.bincount(labels[windows.cut], minlength=setting.n_clusters)
        empty = np.flatnonzero((held < FULL_WINDOWS) & (refills < REFILLS))
        if len(empty):
            own = Costs(fit.gaussians, windows).own(labels) if fit else _distances(windows)
            labels = refill(labels, own, windows, empty)
            refills[empty] += 1
        counts, *found = cluster_statistics(windows, labels, setting.n_clusters)
        alive = counts > 0  # a cluster without frames stays what it was
        means[alive], covariances[alive] = found[0][alive], found[1][alive] + ridge
        lasso = toeplitz_lasso(covariances, windows.reach.window, setting.sparsity, lasso)
        gaussians = Gaussians(means.copy(), lasso.precisions)
        path = trellis(windows, gaussians, setting)
        changed = np.count_nonzero(path.labels != labels)
        labels = path.labels
        converged = bool(changed <= CHANGED * windows.n_frames)
        fit = Fit(path.objective, gaussians, labels, iteration, converged)
        took_s = time.monotonic() - began
        log.log(
            logging.INFO if took_s > SLOW_S else logging.DEBUG,
            "iteration %d: objective %.6g, %d frames changed cluster; at most %d s left",
            iteration,
            path.objective,
            changed,
            round(took_s * (setting.max_iter - iteration)),
        )
        if converged:
            break
    return fit


def _distances(windows: Windows) -> np.ndarray:
    """(T,): squared distance of each frame from the mean of all."""
    found = np.empty(windows.n_frames)
    for begin, end in windows.blocks():
        values = windows.values(begin, end)[:, windows.reach.before :]
        found[begin:end] = (values[:, : end - begin] ** 2).sum(axis=0)
    return found
