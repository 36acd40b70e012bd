"""Where a face rests: what its channels are measured from."""

import numpy as np
from scipy.spatial.distance import cdist

SEEN = 2000  # values that the resting place is sought among
NEAR = 0.1  # standard deviation of the density's kernel, in coefficients
LOW = 2.0  # of two places, one that lies 1 higher in all must be exp(LOW) times as dense
LOW_SD = 0.5  # how well LOW is known: standard deviation of its natural logarithm


def resting_place(values: np.ndarray, weight: np.ndarray | None = None) -> np.ndarray:
    """(d,) the values that faces hold most; of several such places, rather a low one.

    values (n, d): frames, or means of intervals with weight (n,), their frames.
    The mode of all channels at once: a quantile of each channel alone fails where a channel rests
    high and other actions bring it down, as a smile does with the corners of the mouth.
    """
    weight = np.ones(len(values)) if weight is None else np.asarray(weight, dtype=float)
    picked = _picked(weight, np.random.default_rng(0))
    places = _modes(values[picked], weight[picked, None], np.array([LOW]))
    return places[0]


def resting_places(
    values: np.ndarray, weight: np.ndarray, clip: np.ndarray, draws: int, rng: np.random.Generator
) -> np.ndarray:
    """(draws, d) where the face may rest, for all that so many clips tell: a Bayesian bootstrap.

    values (n, d), weight (n,): as for `resting_place`; clip (n,) int: whose they are.
    Source: Rubin 1981, over clips.
    """
    picked = _picked(weight, rng)
    _, clip = np.unique(clip[picked], return_inverse=True)
    drawn = rng.exponential(size=(clip.max() + 1, draws))[clip]  # (n_picked, draws)
    low = LOW * np.exp(rng.normal(0, LOW_SD, draws))
    return _modes(values[picked], weight[picked, None] * drawn, low)


def _picked(weight: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """At most SEEN of the values, heavy ones rather than others."""
    if len(weight) <= SEEN:
        return np.arange(len(weight))
    return np.argpartition(rng.exponential(size=len(weight)) / weight, SEEN)[:SEEN]


def _modes(values: np.ndarray, weights: np.ndarray, low: np.ndarray) -> np.ndarray:
    """(m, d): the densest place under each column of weights (n, m), lowered by low (m,)."""
    near = np.exp(-cdist(values, values, "sqeuclidean") / (2 * NEAR**2))  # (n, n)
    score = np.log(near @ weights) - values.sum(axis=1)[:, None] * low  # (n, m)
    around = near[:, score.argmax(axis=0)] * weights  # (n, m)
    return (around / around.sum(axis=0)).T @ values
