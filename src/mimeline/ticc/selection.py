"""What to choose a number of clusters and a price of switching by: BIC, stability, fits on a path.

Scores of labels alone: what made them, how it was regularised and in what unit it counts does not
matter, so fits of every kind can be compared.
"""

from collections.abc import Callable, Sequence
from itertools import combinations

import numpy as np
from sklearn.metrics import adjusted_rand_score

from .frames import Frames, moments, source
from .model import TICC
from .statistics import CUT
from .windows import Products, Windows, describe, trailing

RIDGE = 1e-6  # added to the moments of channels of unit variance: two may be one and the same


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
        start = fits[beta] = make(beta).fit(X, lengths, start=start)
    start = None
    for beta in reversed(order[1:]):
        other = make(beta).fit(X, lengths, start=start)
        if other.objective_ >= fits[beta].objective_:
            break
        start = fits[beta] = other
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
    frames = source(X, lengths)
    n, used = frames.n_channels, len(np.unique(labels))
    free = used * (n + n * (n + 1) / 2 + n * n * (window - 1)) + (used > 1)
    scored = int(np.maximum(frames.lengths - window + 1, 0).sum())
    likelihood = log_likelihood(frames, None, labels, window) + log_path(labels, frames.lengths)
    return float(-2 * likelihood + free * np.log(max(scored, 1)))


def log_likelihood(X, lengths, labels, window: int) -> float:
    """log p(X | labels), nats: each frame once, in its cluster, given the w - 1 frames before it.

    (The sum over windows, which TICC minimises, counts each frame w times.) The first w - 1 frames
    of a sequence are given. Each cluster's autoregression is estimated from its frames and from
    what one average frame of the series would tell, so that few frames do not fit without an error:
    the unit information prior that BIC stands for (Kass, Wasserman 1995).
    """
    frames = source(X, lengths)
    n = frames.n_channels
    counts, squares = _moments(frames, labels, window)
    prior = squares.sum(axis=0) / max(counts.sum(), 1) + RIDGE * np.eye(squares.shape[1])
    total = 0.0
    for count, seen in zip(counts, squares, strict=True):
        known = seen + prior
        weights = np.linalg.solve(known[:-n, :-n], known[:-n, -n:])  # (1 + (w - 1) n, n)
        error = np.concatenate([-weights, np.eye(n)])  # (1 + wn, n) what is left of a frame
        spread = error.T @ known @ error / (count + 1)
        square = np.trace(np.linalg.solve(spread, error.T @ seen @ error))
        constant = np.linalg.slogdet(spread)[1] + n * np.log(2 * np.pi)
        total -= 0.5 * (count * constant + square)
    return float(total)


def _moments(frames: Frames, labels, window: int) -> tuple[np.ndarray, np.ndarray]:
    """Counts (K,) and second moments (K, 1 + wn, 1 + wn) of each cluster's trailing windows.

    A window is led by a 1, so that the first row holds sums. Channels of unit variance.
    """
    windows = Windows(frames, trailing(window), *moments(frames))
    none = Products.of(np.zeros((window, frames.n_channels, frames.n_channels), dtype=bool))
    clusters, labels = np.unique(labels, return_inverse=True)
    size = 1 + window * frames.n_channels
    counts, squares = np.zeros(len(clusters)), np.zeros((len(clusters), size, size))
    for begin, end in windows.blocks():
        rows = describe(windows.values(begin, end), window, none)  # (1 + wn, B)
        own = labels[begin:end].copy()
        own[windows.cuts(begin, end)[0]] = CUT
        for k in np.unique(own[own != CUT]):
            seen = rows[:, own == k]
            counts[k] += seen.shape[1]
            squares[k] += seen @ seen.T
    return counts, squares


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
