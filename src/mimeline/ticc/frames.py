"""Where frames come from: sequences end to end, of which any stretch can be read.

Whatever has `lengths`, `n_channels` and `read` will do; a fit holds a block of frames at a time,
so that a source may be larger than memory.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

STRETCH = 65_536  # frames read at a time where nothing else matters


class Frames(Protocol):
    """Sequences of frames end to end. lengths (S,) int64, frames of each."""

    lengths: np.ndarray
    n_channels: int

    def read(self, begin: int, end: int) -> np.ndarray:
        """Frames begin to end, (end - begin, n) of any type of number."""


@dataclass(frozen=True)
class ArrayFrames:
    """Frames in memory: X (T, n)."""

    X: np.ndarray
    lengths: np.ndarray

    @property
    def n_channels(self) -> int:
        return self.X.shape[1]

    def read(self, begin, end):
        return self.X[begin:end]


class Separated:
    """One long sequence: a null sequence of constant frames between each two sequences.

    real (T,) bool: which of its frames are those of the sequences.
    """

    def __init__(self, frames: Frames, null_length: int, null_value: float):
        self.frames, self.null_value = frames, null_value
        self.n_channels = frames.n_channels
        parts = np.full(2 * len(frames.lengths) - 1, null_length, dtype=np.int64)
        parts[::2] = frames.lengths
        self.real = np.repeat(np.arange(len(parts)) % 2 == 0, parts)  # (T,)
        self.lengths = np.array([len(self.real)])
        self._counts = np.concatenate([[0], np.cumsum(self.real)])

    def read(self, begin, end):
        values = np.full((end - begin, self.n_channels), float(self.null_value))
        values[self.real[begin:end]] = self.frames.read(self._counts[begin], self._counts[end])
        return values


def source(X, lengths=None) -> Frames:
    """X as a source of frames: (T, n) numbers with lengths (S,), or one that is a source already.

    Raises ValueError that says what was found and expected.
    """
    if hasattr(X, "read") and hasattr(X, "lengths"):
        if lengths is not None:
            raise ValueError("lengths: found some beside a source of frames, which has its own")
        return X
    try:
        X = np.asarray(X)
    except ValueError as error:
        raise ValueError(
            "X: found parts of several shapes, expected (frames, channels): put sequences end to "
            "end and give their lengths"
        ) from error
    if X.ndim != 2 or not X.size or X.dtype.kind not in "fiub":
        raise ValueError(
            f"X: found shape {X.shape} of {X.dtype}, expected numbers (frames, channels), "
            f"both above 0"
        )
    if X.dtype not in (np.float32, np.float64, np.int64):
        X = X.astype(np.float64)
    lengths = np.array([len(X)] if lengths is None else lengths)
    if lengths.ndim != 1 or lengths.dtype.kind not in "iu" or (lengths < 1).any():
        raise ValueError(f"lengths: found {lengths.tolist()}, expected whole numbers above 0")
    if lengths.sum() != len(X):
        raise ValueError(f"lengths: found a sum of {lengths.sum()}, expected {len(X)}, as X has")
    return ArrayFrames(X, lengths.astype(np.int64))


def require_finite(frames: Frames) -> None:
    """Raises ValueError with the place of the first number that is not finite."""
    for begin, end in _stretches(frames):
        values = np.asarray(frames.read(begin, end))
        if not np.isfinite(values).all():
            row, column = np.argwhere(~np.isfinite(values))[0]
            raise ValueError(
                f"X: found {values[row, column]} at frame {begin + row}, channel {column}, "
                f"expected finite numbers"
            )


def moments(frames: Frames) -> tuple[np.ndarray, np.ndarray]:
    """Mean (n,) and standard deviation (n,) of each channel of finite frames.

    Raises ValueError for channels that are constant.
    """
    n_frames = int(frames.lengths.sum())
    total, largest = np.zeros(frames.n_channels), np.zeros(frames.n_channels)
    for begin, end in _stretches(frames):
        values = np.asarray(frames.read(begin, end), dtype=np.float64)
        total += values.sum(axis=0)
        largest = np.maximum(largest, np.abs(values).max(axis=0))
    mean, square = total / n_frames, np.zeros(frames.n_channels)
    for begin, end in _stretches(frames):
        square += ((frames.read(begin, end) - mean) ** 2).sum(axis=0)
    deviation = np.sqrt(square / n_frames)
    constant = np.flatnonzero(deviation <= 1e-9 * np.maximum(largest, 1e-300))
    if len(constant):
        raise ValueError(
            f"X: found constant channels {constant.tolist()}, expected channels that move"
        )
    return mean, deviation


def _stretches(frames: Frames):
    n_frames = int(frames.lengths.sum())
    for begin in range(0, n_frames, STRETCH):
        yield begin, min(begin + STRETCH, n_frames)
