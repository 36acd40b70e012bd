"""What to choose a number of clusters and a price of switching by: BIC, stability, fits on a path.

Scores of labels alone: what made them, how it was regularised and in what unit it counts does not
matter, so fits of every kind can be compared.
"""

from collections.abc import Callable, Sequence
from itertools import combinations

import numpy as np
from sklearn.metrics import adjusted_rand_score

from .model import TICC

RIDGE = 1e-6  # added to the moments of channels of unit variance: two may be one and the same
AT_ONCE = 65_536  # windows that are held at a time


def along_betas(
    make: Callable[[float], TICC], betas: Sequence[float], X, lengths=None
) -> dict[float, TICC]:
    """A fit of X (T, n) for each of betas, each from where the one before ended.

    make: beta → an unfitted TICC, all else alike. The smallest beta's fit searches its own start;
    from there beta rises, which ended lower than where it falls. A large beta may be better off
    with clusters that no small one would find: the largest has a search too, and where that wins,
    it is taken down for as long as it does.
    """
    order = sorted(betas)
    fits: dict[float, TICC] = {}
    start = None
    for beta in order:
        fits[beta] = make(beta).fit(X, lengths, start=start)
        start = fits[beta].labels_
    start = None
    for beta in reversed(order[1:]):
        other = make(beta).fit(X, lengths, start=start)
        if other.objective_ >= fits[beta].objective_:
            break
        fits[beta], start = other, other.labels_
    return fits


def bic(X, lengths, labels, window: int) -> float:
    """The Bayesian information criterion of labels (T,), twice nats; lower is better.

    -2 (log p(X | labels) + log p(labels)) + parameters * log(frames), Schwarz 1978. The labels are
    paid for as in the ICL of Biernacki, Celeux, Govaert 2000 (`log_path`, one parameter). A cluster
    of block-Toeplitz windows is a Gaussian autoregression of order w - 1, of n + n (n + 1) / 2 +
    n^2 (w - 1) parameters (`log_likelihood`), all of them counted: BIC asks for the likelihood at
    its maximum, so no shrunk estimate takes part.
    X (T, n) · lengths (S,): sequences end to end, in any order. Channels count in units of their
    deviation.
    """
    n = X.shape[1]
    free = len(np.unique(labels)) * (n + n * (n + 1) / 2 + n * n * (window - 1)) + 1
    scored = int(np.maximum(np.asarray(lengths) - window + 1, 0).sum())
    likelihood = log_likelihood(X, lengths, labels, window) + log_path(labels, lengths)
    return float(-2 * likelihood + free * np.log(max(scored, 1)))


def log_likelihood(X, lengths, labels, window: int) -> float:
    """log p(X | labels), nats: each frame once, in its cluster, given the w - 1 frames before it.

    (The sum over windows, which TICC minimises, counts each frame w times.) The first w - 1 frames
    of a sequence are given. Each cluster's autoregression is estimated from its frames and from
    what one average frame of the series would tell, so that few frames do not fit without an error:
    the unit information prior that BIC stands for (Kass, Wasserman 1995).
    """
    n = X.shape[1]
    counts, moments = _moments((X - X.mean(axis=0)) / X.std(axis=0), lengths, labels, window)
    prior = moments.sum(axis=0) / max(counts.sum(), 1) + RIDGE * np.eye(moments.shape[1])
    total = 0.0
    for count, seen in zip(counts, moments, strict=True):
        known = seen + prior
        weights = np.linalg.solve(known[:-n, :-n], known[:-n, -n:])  # (1 + (w - 1) n, n)
        error = np.concatenate([-weights, np.eye(n)])  # (1 + wn, n) what is left of a frame
        spread = error.T @ known @ error / (count + 1)
        square = np.trace(np.linalg.solve(spread, error.T @ seen @ error))
        constant = np.linalg.slogdet(spread)[1] + n * np.log(2 * np.pi)
        total -= 0.5 * (count * constant + square)
    return float(total)


def _moments(X, lengths, labels, window: int) -> tuple[np.ndarray, np.ndarray]:
    """Counts (K,) and second moments (K, 1 + wn, 1 + wn) of each cluster's trailing windows.

    A window is led by a 1, so that the first row holds sums.
    """
    clusters, labels = np.unique(labels, return_inverse=True)
    size = 1 + window * X.shape[1]
    counts, moments = np.zeros(len(clusters)), np.zeros((len(clusters), size, size))
    ends = np.cumsum(lengths)
    age = np.arange(len(X)) - np.repeat(ends - lengths, lengths)  # (T,) frames before it
    frames = np.flatnonzero(age >= window - 1)
    for some in np.split(frames, range(AT_ONCE, len(frames), AT_ONCE)):
        seen = X[some[:, None] + np.arange(1 - window, 1)].reshape(len(some), -1)  # (N, wn)
        seen = np.concatenate([np.ones((len(some), 1)), seen], axis=1)  # (N, 1 + wn)
        for k in np.unique(labels[some]):
            own = seen[labels[some] == k]
            counts[k] += len(own)
            moments[k] += own.T @ own
    return counts, moments


def log_path(labels, lengths) -> float:
    """log p(labels), nats, in the Markov chain that one price for every switch stands for.

    A sequence begins in any of the K clusters in use; each frame then switches with one
    probability, taken at its likeliest, to each other cluster alike.
    labels (T,) · lengths (S,), sequences apart.
    """
    clusters = len(np.unique(labels))
    if clusters == 1:
        return 0.0
    switched, steps = n_switches(labels, lengths), len(labels) - len(lengths)
    counts = np.array([switched, steps - switched])
    counts = counts[counts > 0]
    log_steps = float((counts * np.log(counts / steps)).sum()) if steps else 0.0
    return log_steps - switched * np.log(clusters - 1) - len(lengths) * np.log(clusters)


def n_switches(labels, lengths) -> int:
    """How often labels (T,) change within sequences of lengths (S,)."""
    changed = np.diff(labels) != 0  # (T - 1,)
    changed[np.cumsum(lengths)[:-1] - 1] = False
    return int(changed.sum())


def stability(labelings: Sequence) -> float:
    """Mean adjusted Rand index of each two of several labels (T,) of a series.

    1 where they group the frames alike, about 0 where by chance; NaN of fewer than two (Hubert,
    Arabie 1985).
    """
    indices = [adjusted_rand_score(a, b) for a, b in combinations(labelings, 2)]
    return float(np.mean(indices)) if indices else float("nan")
