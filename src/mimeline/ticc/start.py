"""Where TICC starts, and where a cluster that lost all its frames starts again."""

import warnings

import numpy as np
from sklearn.exceptions import ConvergenceWarning
from sklearn.mixture import GaussianMixture

from .windows import Windows

SPANS = (0, 1, 4, 12)  # windows that a start looks around a frame; 0: the frame alone
RIDGE = 1e-3  # added to a component's variances, in units of the channels' own
EM_STEPS = 50  # a start need not be an optimum
RESEED_FRAMES = 20  # least frames that a cluster is given back


def starts(X, lengths, n_clusters: int, window: int, repeats: int, rng: np.random.Generator):
    """Yields labels (T,), `repeats` for each span of SPANS.

    Gaussian mixtures of what is around a frame: the mean and the deviation of each channel over a
    span. What tells one motion from another may be where it lies, how it swings or both, and over a
    short or a long time: the objective finds out which start fits.
    X (T, n), channels of unit variance · lengths (S,).
    """
    for span in SPANS:
        features = surroundings(X, lengths, span * window) if span else X
        features = features / np.maximum(features.std(axis=0), 1e-9)
        for _ in range(repeats if n_clusters > 1 else 1):
            yield _mixture(features, n_clusters, rng)


def surroundings(X, lengths, span: int) -> np.ndarray:
    """(T, 2n): mean and standard deviation of X (T, n) over span frames to each side of a frame.

    Cut at the borders of the sequences.
    """
    ends = np.repeat(np.cumsum(lengths), lengths)  # (T,)
    begins = ends - np.repeat(lengths, lengths)  # (T,)
    frame = np.arange(len(X))
    low, high = np.maximum(frame - span, begins), np.minimum(frame + span + 1, ends)
    count = (high - low)[:, None]
    mean = _sums(X, low, high) / count  # (T, n)
    square = _sums(X**2, low, high) / count  # (T, n)
    return np.concatenate([mean, np.sqrt(np.maximum(square - mean**2, 0))], axis=1)


def _sums(X, low, high):
    total = np.concatenate([np.zeros((1, X.shape[1])), np.cumsum(X, axis=0)])
    return total[high] - total[low]


def _mixture(features, n_clusters, rng):
    mixture = GaussianMixture(
        n_clusters,
        init_params="k-means++",
        reg_covar=RIDGE,
        max_iter=EM_STEPS,
        random_state=int(rng.integers(2**31)),
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        return mixture.fit_predict(features)


def excerpt(lengths, window: int, amount: int, piece: int, rng: np.random.Generator):
    """Begins and lengths of pieces of the sequences, drawn at random: some `amount` frames in all.

    Sequences are cut into pieces of at most `piece` frames; the drawn ones stay in order. Those
    that hold no whole window come last.
    """
    begins, sizes = [], []
    for end, length in zip(np.cumsum(lengths), lengths, strict=True):
        begin = np.arange(end - length, end, piece)
        begins.append(begin)
        sizes.append(np.minimum(begin + piece, end) - begin)
    begins, sizes = np.concatenate(begins), np.concatenate(sizes)
    order = rng.permutation(len(begins))
    order = order[np.argsort(sizes[order] < window, kind="stable")]
    drawn = np.sort(order[np.cumsum(sizes[order]) - sizes[order] < amount])
    return begins[drawn], sizes[drawn]


def refill(labels, costs, windows: Windows, empty) -> np.ndarray:
    """Labels in which each empty cluster is given the run of frames that is explained worst.

    labels (T,) · costs (T,) of each frame in its own cluster · empty: clusters without whole
    windows. A run lies in one sequence, is max(20, 4 w) frames or as long as the longest sequence,
    and no two clusters get overlapping ones.
    """
    labels, lengths = labels.copy(), windows.frames.lengths
    size = min(max(RESEED_FRAMES, 4 * windows.reach.window), int(lengths.max()))
    total = np.concatenate([[0.0], np.cumsum(costs)])
    runs = total[size:] - total[:-size]  # (T - size + 1,) cost of the run that begins at a frame
    ends = np.cumsum(lengths)
    first = np.arange(len(runs))
    runs[first + size > ends[np.searchsorted(ends, first, side="right")]] = -np.inf
    for k in empty:
        begin = int(np.argmax(runs))
        if not np.isfinite(runs[begin]):
            break
        labels[begin : begin + size] = k
        runs[max(begin - size + 1, 0) : begin + size] = -np.inf
    return labels
