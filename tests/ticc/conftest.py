import numpy as np
import pytest

from mimeline.ticc import TICC
from mimeline.ticc.frames import ArrayFrames
from mimeline.ticc.windows import Reach, Windows, centred

MEANS = np.array([[0.0, 0.0, 0.0], [1.5, -1.0, 0.0], [0.0, 0.0, 0.0]])
MIXING = np.array(
    [np.eye(3), np.eye(3), [[0.2, 0.0, 0.0], [0.0, 2.0, 1.8], [0.0, 1.8, 2.0]]]
)  # the third motion lies where the first does and differs in how its channels go together


@pytest.fixture(scope="session")
def plant():
    return _plant


def _plant(lengths, seed=0):
    """Sequences of three motions, 30-60 frames each: X (T, 3), truth (T,)."""
    rng = np.random.default_rng(seed)
    X, truth = [], []
    for length in lengths:
        state = int(rng.integers(3))
        labels = []
        while len(labels) < length:
            labels += [state] * int(rng.integers(30, 61))
            state = int((state + rng.integers(1, 3)) % 3)
        labels = np.array(labels[:length])
        noise = 0.4 * rng.normal(size=(length, 3))
        X.append(MEANS[labels] + np.einsum("tij,tj->ti", MIXING[labels], noise))
        truth.append(labels)
    return np.concatenate(X), np.concatenate(truth)


@pytest.fixture(scope="session")
def windows_of():
    return _windows


def _windows(X, lengths, window: int, reach: Reach | None = None) -> Windows:
    """The windows of X as it is, in float64."""
    frames = ArrayFrames(np.asarray(X, dtype=float), np.asarray(lengths))
    n = frames.n_channels
    return Windows(frames, reach or centred(window), np.zeros(n), np.ones(n))


LENGTHS = np.array([120, 200, 3, 150, 90, 1, 240, 160])


@pytest.fixture(scope="session")
def series():
    X, truth = _plant(LENGTHS)
    return X, LENGTHS, truth


@pytest.fixture(scope="session")
def fitted(series):
    X, lengths, _ = series
    return TICC(n_clusters=3, window=4, beta=5.0, max_iter=15).fit(X, lengths)
