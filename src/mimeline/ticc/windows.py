"""The window around each frame, and what of it a model sees.

Nothing is ever stacked. With a block-Toeplitz precision the likelihood of a window needs its frames
and, per lag and pair of channels, one sum of products over the window. The same numbers, summed
over the windows of a cluster, are all that the cluster's estimate needs.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from .frames import Frames

BLOCK, LEAST_BLOCK = 1024, 64  # frames whose windows are described at a time, most and least:
CELLS = 2**20  # numbers of a description, so that it stays in the processor's cache


@dataclass(frozen=True)
class Reach:
    """How many frames a frame's window holds before and after it."""

    before: int
    after: int

    @property
    def window(self) -> int:
        """Frames of a whole window, w."""
        return self.before + 1 + self.after


def centred(window: int) -> Reach:
    """A window to both sides: where windows trail, labels come (w - 1) / 2 frames late."""
    return Reach(window - 1 - window // 2, window // 2)


def trailing(window: int) -> Reach:
    """A window that ends with its frame (Hallac et al. 2017, section 2)."""
    return Reach(window - 1, 0)


ALIGNMENTS = {"centred": centred, "trailing": trailing}


class Windows:
    """The windows of a source's frames, cut at the borders of its sequences.

    What they see are frames less center (n,), in units of scale (n,).
    n_frames: T · opens (T,) bool: where a sequence begins · cut (M,): the frames whose window is
    cut, ascending · lacks (C, 2): how many frames a cut window lacks at its front and its back, in
    the ways that there are · kind (M,): which of these each cut window is.
    """

    def __init__(self, frames: Frames, reach: Reach, center: np.ndarray, scale: np.ndarray):
        self.frames, self.reach = frames, reach
        self.center, self.scale = center, scale
        lengths = frames.lengths
        self.n_frames = int(lengths.sum())
        ends = np.cumsum(lengths)
        begins = ends - lengths
        self.opens = np.zeros(self.n_frames, dtype=bool)
        self.opens[begins] = True
        self.cut, lacks = _cuts(begins, ends, reach.before, reach.after)
        self.lacks, self.kind = np.unique(lacks, axis=0, return_inverse=True)
        products = Products.every(reach.window, frames.n_channels)
        rows = 1 + reach.window * frames.n_channels + len(products.lag)
        self._block = min(max(CELLS // rows, LEAST_BLOCK), BLOCK)

    def blocks(self):
        """(begin, end) of consecutive blocks of frames."""
        for begin in range(0, self.n_frames, self._block):
            yield begin, min(begin + self._block, self.n_frames)

    def values(self, begin: int, end: int) -> np.ndarray:
        """What the windows of frames begin to end see: channels (n, end - begin + w - 1).

        Zeros where they would reach over the ends of the source.
        """
        low, high = begin - self.reach.before, end + self.reach.after
        read = self.frames.read(max(low, 0), min(high, self.n_frames))
        values = np.zeros((self.frames.n_channels, high - low))
        _scale(read, self.center, self.scale, values[:, max(-low, 0) :])
        return values

    def cuts(self, begin: int, end: int) -> tuple[np.ndarray, np.ndarray]:
        """Frames of begin to end whose window is cut, counted from begin, and of which kind."""
        some = slice(*self.cut.searchsorted((begin, end)))
        return self.cut[some] - begin, self.kind[some]


def _cuts(begins, ends, before, after):
    near = [begins + i for i in range(before)] + [ends - 1 - i for i in range(after)]
    own = np.tile(np.arange(len(begins)), before + after)
    frame = np.concatenate([*near, np.zeros(0, np.int64)])
    inside = (frame >= begins[own]) & (frame < ends[own])
    frame, index = np.unique(frame[inside], return_index=True)
    own = own[inside][index]
    front = np.maximum(before - (frame - begins[own]), 0)
    back = np.maximum(after - (ends[own] - 1 - frame), 0)
    return frame, np.stack([front, back], axis=1)  # (M,), (M, 2)


@njit(cache=True)
def _scale(frames, center, scale, values):
    for i in range(frames.shape[1]):
        for t in range(len(frames)):
            values[i, t] = (frames[t, i] - center[i]) / scale[i]


@dataclass(frozen=True)
class Products:
    """Which products a model asks for: x_first of a frame times x_second of one `lag` later.

    Each is summed over a window. lag, first, second (F,); within a frame first <= second, so that
    no pair counts twice.
    """

    lag: np.ndarray
    first: np.ndarray
    second: np.ndarray

    @classmethod
    def of(cls, held: np.ndarray) -> "Products":
        """Those of held (w, n, n) bool: lag, channel, channel of the later frame."""
        held = held.copy()
        held[0] = np.triu(held[0])
        return cls(*np.nonzero(held))

    @classmethod
    def every(cls, window: int, n_channels: int) -> "Products":
        """All that a window has."""
        return cls.of(np.ones((window, n_channels, n_channels), dtype=bool))


def describe(values: np.ndarray, window: int, products: Products) -> np.ndarray:
    """What the windows of a block hold: (1 + wn + F, B), a column per window.

    values (n, B + w - 1). The rows: 1; the window's frames, oldest first; its sums of products.
    """
    n, size = len(values), values.shape[1] - window + 1
    rows = np.empty((1 + window * n + len(products.lag), size))
    _describe(values, window, products.lag, products.first, products.second, rows)
    return rows


@njit(cache=True)
def _describe(values, window, lags, firsts, seconds, rows):
    n, size = len(values), rows.shape[1]
    rows[0] = 1.0
    for a in range(window):
        for i in range(n):
            rows[1 + a * n + i] = values[i, a : a + size]
    product = np.empty(size + window)
    for f in range(len(lags)):
        terms = window - lags[f]
        first, second = values[firsts[f]], values[seconds[f], lags[f] :]
        for t in range(size + terms - 1):
            product[t] = first[t] * second[t]
        _add_up(product, terms, rows[1 + window * n + f])


@njit(cache=True)
def _add_up(product, terms, sums):
    """Sums of `terms` neighbours, four at a time: it is the memory that takes the time."""
    first = terms % 4
    if first == 0:
        sums[:] = 0.0
    elif first == 1:
        sums[:] = product[: len(sums)]
    elif first == 2:
        one = product[1:]
        for t in range(len(sums)):
            sums[t] = product[t] + one[t]
    else:
        one, two = product[1:], product[2:]
        for t in range(len(sums)):
            sums[t] = product[t] + one[t] + two[t]
    for a in range(first, terms, 4):
        zero, one, two, three = product[a:], product[a + 1 :], product[a + 2 :], product[a + 3 :]
        for t in range(len(sums)):
            sums[t] += (zero[t] + one[t]) + (two[t] + three[t])
