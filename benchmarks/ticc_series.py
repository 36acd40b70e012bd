"""Series for TICC's benchmarks: clips of the toy world, or of Gaussian states, drawn again."""

from dataclasses import dataclass

import numpy as np
from sklearn.mixture import GaussianMixture

from mimeline.ticc.parquet import ParquetFrames
from mimeline.toy import simulate

K, SEED = 10, 0
PEOPLE, CLIPS = 20, 100  # of the toy world that the face series draw from
SEGMENT = (50, 350)  # frames of a state's segments
BROW = ("browDownLeft", "browInnerUp", "browOuterUpLeft")
FACE = (*BROW, "browDownRight", "browOuterUpRight")
FACE += ("mouthSmileLeft", "mouthSmileRight", "mouthFrownLeft", "mouthFrownRight")
CHANNELS = {3: BROW, 9: FACE}
NOISE = {"face": 0.01, "states": 0.1}  # deviation of what is added to a clip drawn again


@dataclass(frozen=True)
class Task:
    """A series to be made, and what to ask of it."""

    data: str
    n: int
    window: int
    frames: int
    sparsity: float
    beta: float

    def __str__(self):
        return (
            f"{self.data:6} n={self.n} w={self.window:<2} K={K} T={self.frames:<8} "
            f"sparsity={self.sparsity:<5g} beta={self.beta:g}"
        )


@dataclass
class Series:
    """Clips end to end: X (T, n) or a source of it, lengths (S,), labels (T,) to start from."""

    X: np.ndarray | ParquetFrames
    lengths: np.ndarray
    labels: np.ndarray


def face_clips(n: int) -> list[np.ndarray]:
    """Clips (frames, n) of the toy world's tracked channels."""
    motion = simulate(PEOPLE, CLIPS, SEED).motion
    return [clip.to_numpy(float) for _, clip in motion.groupby("clip_id")[list(CHANNELS[n])]]


def state_clips(n: int, window: int) -> list[np.ndarray]:
    """Clips (frames, n) of one state each: moving averages of white noise over a window."""
    rng = np.random.default_rng(SEED)
    filters = rng.normal(size=(K, window, n, n))
    filters /= np.sqrt((filters**2).sum(axis=(1, 2), keepdims=True))  # unit variance
    means = 0.5 * rng.normal(size=(K, n))
    clips = []
    for state in rng.permutation(np.arange(CLIPS) % K):
        noise = rng.normal(size=(rng.integers(*SEGMENT) + window - 1, n))
        parts = [noise[lag : len(noise) - window + 1 + lag] for lag in range(window)]
        moving = sum(part @ filters[state, lag] for lag, part in enumerate(parts))
        clips.append(means[state] + moving)
    return clips


def make(task: Task) -> Series:
    """The task's series, at least as long as asked; labels of a mixture of single frames."""
    rng = np.random.default_rng(SEED)
    clips = face_clips(task.n) if task.data == "face" else state_clips(task.n, task.window)
    frames = np.concatenate(clips)
    mixture = GaussianMixture(K, reg_covar=1e-3, max_iter=50, random_state=SEED)
    labels = mixture.fit_predict(frames / frames.std(axis=0))
    ends = np.cumsum([len(clip) for clip in clips])
    pieces = [slice(end - len(clip), end) for end, clip in zip(ends, clips, strict=True)]
    drawn, total = [], 0
    while total < task.frames:
        drawn.append(pieces[rng.integers(len(pieces))])
        total += drawn[-1].stop - drawn[-1].start
    X, start = np.empty((total, task.n)), np.empty(total, np.int64)
    at = 0
    for piece in drawn:  # clip by clip, so that the making needs no more memory than the series
        end = at + piece.stop - piece.start
        X[at:end] = frames[piece]
        X[at:end] += NOISE[task.data] * rng.standard_normal((end - at, task.n))
        start[at:end] = labels[piece]
        at = end
    return Series(X, np.array([piece.stop - piece.start for piece in drawn]), start)
