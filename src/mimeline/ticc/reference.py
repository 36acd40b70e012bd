"""What the original TICC code computes, for comparison; nobody should cluster with it.

The code is github.com/davidhallac/TICC at 85d45d10 (2020-06-14), the last version; this is written
from its behaviour and gives its labels, iteration by iteration. Where it departs from its paper
(Hallac, Vare, Boyd, Leskovec, KDD 2017):

- Windows look forward: label i belongs to the frames i .. i + w - 1, the paper's to the w frames
  that end in i. There are T - w + 1 labels.
- The last w - 1 frames are never read; windows that reach them hold zeros instead, and the means
  and covariances include these windows.
- The last w - 1 labels are not estimated: every cluster costs nothing there, so that they continue
  the label before (with beta = 0 they are cluster 0).
- Costs (eq. 2, 3) lack the factor 1/2 and the constant of 2 pi. So beta is twice the paper's.
- Covariances are divided by |P_i| - 1 and not by |P_i|.
- The lasso (eq. 4) weighs sparsity alike in all clusters; the paper's is divided by |P_i|, which
  makes it the objective that assignment lowers too. The diagonal is penalised as well, which the
  paper leaves to its matrix of weights.
- ADMM starts from zero each time with rho = 1 and adds 1e-4 to both tolerances. What is kept is
  its x, which is neither sparse nor exactly block-Toeplitz, instead of z, which is both.
- A cluster that the assignment leaves empty gets 20 frames in a row, drawn from a large one; the
  paper does not say what to do. After the first iteration nothing is done: an empty cluster
  competes with the estimates that it had.
- It stops when labels repeat. Since the two steps lower two objectives, it is not a descent: the
  cost may rise, labels may go round in circles, and a cluster that must be refilled each time
  keeps it from stopping.

Three of these have no say in what TICC is, yet they move labels: the zeros at the end, |P_i| - 1,
and ADMM that stops early, with errors of some 1e-3 in a precision. `mended` computes without them.
One thing is always mended: log det does not overflow, as the original's does from some 325 entries
of a window on.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from sklearn.mixture import GaussianMixture

REFILL = 20  # frames given to an empty cluster
ADMM_STEPS, TOLERANCE, SLACK = 1000, 1e-6, 1e-4
MENDED_STEPS, MENDED_TOLERANCE = 20_000, 1e-7


@dataclass(frozen=True)
class Iteration:
    """One round: estimates, the labels that they lead to, and what was refilled.

    means (K, wn) and precisions (K, wn, wn) from the labels before · assigned (T - w + 1,) int64,
    the cheapest path · labels, the same after refilling, with which the next round begins ·
    refilled: the clusters that the path left empty and that were given frames.
    """

    means: np.ndarray
    precisions: np.ndarray
    assigned: np.ndarray
    labels: np.ndarray
    refilled: tuple[int, ...]


def reference_iterations(
    X, n_clusters, window, beta, sparsity, max_iter, start=None, *, seed=102, mended=False
) -> Iterator[Iteration]:
    """The iterations of the original code on X (T, n), until it stops.

    beta: the code's, twice the paper's. start: labels (T - w + 1,) to begin from; None: those of
    a Gaussian mixture, as the original, which depends on scikit-learn's version. seed: of the
    original's random stream (102 there), which start, if given, takes nothing of. mended: whole
    windows alone, and all of them labelled by their cost; covariances divided by |P_i|; ADMM until
    it has converged.
    Raises ValueError where the original fails: a cluster without windows in the start, or a cluster
    of one window.
    """
    rng = np.random.RandomState(seed)
    windows = forward_windows(X, window, mended)  # (N, wn)
    n_counted = len(windows) if mended else len(windows) - window + 1
    rng.permutation(len(X) - window)  # the original shuffles all frames, then sorts them again
    labels = mixture_start(windows, n_clusters, rng) if start is None else np.array(start)
    if not np.isin(np.arange(n_clusters), labels).all():
        raise ValueError(f"start: found an empty cluster, expected windows in all {n_clusters}")
    means = np.empty((n_clusters, windows.shape[1]))
    covariances = np.empty((n_clusters, windows.shape[1], windows.shape[1]))
    before = None
    for iteration in range(max_iter):
        _estimate(windows, labels, window, sparsity, means, covariances, mended)
        estimates = means.copy(), np.linalg.inv(covariances)
        assigned = cheapest_path(_costs(windows, n_counted, means, covariances), beta)
        labels, refilled = assigned.copy(), ()
        if iteration > 0:
            refilled = _refill(labels, windows, means, covariances, rng)
        yield Iteration(*estimates, assigned, labels, refilled)
        if np.array_equal(before, labels):
            return
        before = assigned


def forward_windows(X, window, mended=False) -> np.ndarray:
    """The windows (T - w + 1, wn) of X (T, n), frames in order.

    The last w - 1 frames are zeros, unless mended.
    """
    read = np.array(X, dtype=np.float64)  # (T, n)
    if not mended:
        read[len(read) - window + 1 :] = 0
    views = sliding_window_view(read, window, axis=0)  # (T - w + 1, n, w)
    return views.swapaxes(1, 2).reshape(len(views), -1)


def mixture_start(windows, n_clusters, rng) -> np.ndarray:
    """Labels (N,) of windows (N, wn): the components of a full Gaussian mixture."""
    return GaussianMixture(n_clusters, random_state=rng).fit(windows).predict(windows)


def _estimate(windows, labels, window, sparsity, means, covariances, mended) -> None:
    """Write the estimates of the clusters that have windows over the old ones."""
    present = np.unique(labels)
    empirical = np.empty((len(present), *covariances.shape[1:]))
    for row, k in enumerate(present):
        members = windows[labels == k]
        if len(members) == 1:
            raise ValueError(f"cluster {k}: found one window, expected two or more")
        means[k] = members.mean(axis=0)
        empirical[row] = np.cov(members.T, bias=mended)
    covariances[present] = np.linalg.inv(lasso(empirical, window, sparsity, mended))


def lasso(empirical, window, sparsity, mended=False) -> np.ndarray:
    """The original's precisions (K, wn, wn) for covariances (K, wn, wn): ADMM's x after its stop.

    mended: after it has converged.
    Source: Hallac et al. 2017, eq. 4 and its ADMM, with the departures named above. Residuals are
    norms over the upper triangle.
    """
    size = empirical.shape[1]
    upper = np.triu_indices(size)
    x, z, u = (np.zeros_like(empirical) for _ in range(3))
    active = np.arange(len(empirical))
    steps, tolerance = (MENDED_STEPS, MENDED_TOLERANCE) if mended else (ADMM_STEPS, TOLERANCE)
    floor = tolerance * np.sqrt(len(upper[0])) + (0 if mended else SLACK)
    for step in range(steps):
        old = z[active]
        values, vectors = np.linalg.eigh(old - u[active] - empirical[active])
        roots = (values + np.sqrt(values**2 + 4)) / 2  # (A, wn)
        new = vectors * roots[:, None, :] @ vectors.swapaxes(1, 2)
        x[active] = np.triu(new) + np.triu(new, 1).swapaxes(1, 2)
        z[active] = _shrunk(x[active] + u[active], window, sparsity)
        u[active] += x[active] - z[active]
        if step == 0:
            continue
        size_x, size_z, size_u, primal, dual = (
            np.linalg.norm(A[:, *upper], axis=1)
            for A in (x[active], z[active], u[active], x[active] - z[active], z[active] - old)
        )
        near = primal <= floor + tolerance * np.maximum(size_x, size_z)
        near &= dual <= floor + tolerance * size_u
        active = active[~near]
        if not len(active):
            break
    return x


def _shrunk(A, window, sparsity) -> np.ndarray:
    """Symmetric A (K, wn, wn) made block-Toeplitz, then soft-thresholded by sparsity."""
    n = A.shape[1] // window
    blocks = A.reshape(-1, window, n, window, n).swapaxes(2, 3)  # (K, w, w, n, n)
    shrunk = np.empty_like(blocks)
    for lag in range(window):
        rows = np.arange(window - lag)
        mean = blocks[:, rows, rows + lag].mean(axis=1)  # (K, n, n)
        mean = np.sign(mean) * np.maximum(np.abs(mean) - sparsity, 0)
        shrunk[:, rows, rows + lag] = mean[:, None]
        shrunk[:, rows + lag, rows] = mean.swapaxes(1, 2)[:, None]
    return shrunk.swapaxes(2, 3).reshape(A.shape)


def _costs(windows, n_counted, means, covariances) -> np.ndarray:
    """(N, K): Mahalanobis distance + log det of the covariance, zero past n_counted windows."""
    costs = np.zeros((len(windows), len(means)))
    counted = windows[:n_counted]
    log_dets = np.linalg.slogdet(covariances)[1]
    for k, precision in enumerate(np.linalg.inv(covariances)):
        centred = counted - means[k]
        distances = np.einsum("ti,ti->t", centred @ precision, centred)
        costs[: len(counted), k] = distances + log_dets[k]
    return costs


def cheapest_path(costs, beta) -> np.ndarray:
    """Labels (N,) int64 that minimise costs (N, K) + beta per switch, ties as in the original.

    It looks from the end backward and reads the path forward; of equal clusters the first is taken.
    Staying costs a + beta - beta, in this order: the rounding decides ties too. In O(N K) instead
    of O(N K^2), for the minimum over all clusters is the same for each.
    Source: Hallac et al. 2017, algorithm 1.
    """
    ahead = np.zeros_like(costs)  # the cheapest rest after each window
    for t in range(len(costs) - 2, -1, -1):
        switch = ahead[t + 1] + costs[t + 1] + beta
        ahead[t] = np.minimum(switch - beta, switch.min())
    switch = ahead + costs + beta
    stay = (switch - beta).tolist()
    best, price = switch.argmin(axis=1).tolist(), switch.min(axis=1).tolist()
    path = np.empty(len(costs), np.int64)
    path[0] = label = int(np.argmin(ahead[0] + costs[0]))
    for t in range(1, len(costs)):
        if (price[t], best[t]) < (stay[t][label], label):
            label = best[t]
        path[t] = label
    return path


def _refill(labels, windows, means, covariances, rng) -> tuple[int, ...]:
    """Give each empty cluster REFILL windows in a row, written into labels; returns which.

    Donors are taken in turn, the largest covariance first; the run starts at a random window of
    the donor. The refilled cluster takes over the donor's covariance and, as its mean, the run's
    last window: should another refilled cluster cover the run, these are the estimates it keeps.
    """
    assigned, n_clusters = labels.copy(), len(means)
    held = np.bincount(assigned, minlength=n_clusters)
    norms = [float(np.linalg.norm(covariance)) for covariance in covariances]
    order = sorted(range(n_clusters), key=lambda k: (norms[k], k), reverse=True)
    donors = [k for k in order if held[k]]
    empty = np.flatnonzero(held == 0)
    for turn, k in enumerate(empty):
        donor = donors[turn % len(donors)]
        first = rng.choice(np.flatnonzero(assigned == donor))
        run = slice(first, min(first + REFILL, len(labels)))
        labels[run] = k
        covariances[k], means[k] = covariances[donor], windows[run.stop - 1]
    return tuple(empty.tolist())
