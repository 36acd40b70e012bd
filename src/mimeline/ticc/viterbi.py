"""The cheapest labelling of sequences whose every switch of cluster costs beta."""

from collections.abc import Callable, Iterable

import numpy as np
from numba import njit

BITS = 16  # of a word of `stays`


class Trellis:
    """The cheapest path through the clusters, found a block of frames at a time.

    costs: gives (end - begin, K) for the frames of a block · blocks: (begin, end), consecutive,
    from 0 to T · opens (T,) bool: where a sequence begins; a switch there is free · beta >= 0.

    labels (T,) int64 minimise the costs plus beta per switch, and objective is that minimum. Exact
    in O(T K): with one price for every switch, the best predecessor of a cluster is itself or the
    cheapest of all (Hallac et al. 2017, algorithm 1). Ties stay, then take the smallest index.
    Per frame only a bit for each cluster and the cheapest one are kept.
    """

    def __init__(
        self,
        costs: Callable[[int, int], np.ndarray],
        blocks: Iterable[tuple[int, int]],
        opens: np.ndarray,
        n_clusters: int,
        beta: float,
    ):
        self._costs, self._blocks = costs, list(blocks)
        self._opens, self._beta = opens, float(beta)
        stays = np.empty((len(opens), -(-n_clusters // BITS)), dtype=np.uint16)
        cheapest = np.empty(len(opens), dtype=np.uint16)
        so_far, self._entries, self.objective = np.zeros(n_clusters), [], 0.0
        for begin, end in self._blocks:
            self._entries.append(so_far.copy())
            part = slice(begin, end)
            self.objective += _forward(
                costs(begin, end), opens[part], self._beta, so_far, stays[part], cheapest[part]
            )
        self.objective += float(so_far.min())
        self.labels = _trace(stays, cheapest, opens, int(np.argmin(so_far)))

    def margins(self) -> np.ndarray:
        """(T,) >= 0: how much dearer the best path becomes when a frame must leave its cluster.

        Forward and backward minima meet at every frame, so the figure is exact. Infinite where
        there is a single cluster. The costs are asked for once more, the last block first.
        """
        margins = np.empty(len(self._opens))
        after = np.zeros(len(self._entries[0]))  # cheapest way on, should the sequence end here
        for (begin, end), entry in zip(
            reversed(self._blocks), reversed(self._entries), strict=True
        ):
            part = slice(begin, end)
            ends = np.append(self._opens[begin + 1 : end + 1], end == len(self._opens))
            _margins(
                self._costs(begin, end),
                self._opens[part],
                ends[: end - begin],
                self._beta,
                entry,
                after,
                self.labels[part],
                margins[part],
            )
        return margins


@njit(cache=True)
def _forward(costs, opens, beta, so_far, stays, cheapest):
    n_frames, n_clusters = costs.shape
    closed = 0.0
    for t in range(n_frames):
        least = so_far[0]
        for k in range(1, n_clusters):
            least = min(least, so_far[k])
        best = 0
        while best < n_clusters - 1 and so_far[best] != least:
            best += 1
        cheapest[t] = best
        if opens[t]:
            closed += least
            so_far[:] = costs[t]
            continue
        switch = least + beta
        for word in range(stays.shape[1]):
            bits = 0
            for k in range(word * BITS, min((word + 1) * BITS, n_clusters)):
                bits |= (so_far[k] <= switch) << (k - word * BITS)
                so_far[k] = costs[t, k] + min(so_far[k], switch)
            stays[t, word] = bits
    return closed


@njit(cache=True)
def _trace(stays, cheapest, opens, last):
    labels = np.empty(len(opens), np.int64)
    k = last
    for t in range(len(opens) - 1, -1, -1):
        labels[t] = k
        if opens[t] or not (stays[t, k // BITS] >> (k % BITS)) & 1:
            k = np.int64(cheapest[t])
    return labels


@njit(cache=True)
def _margins(costs, opens, ends, beta, entry, after, labels, margins):
    n_frames, n_clusters = costs.shape
    so_far = np.empty((n_frames, n_clusters))
    for t in range(n_frames):
        before = entry if t == 0 else so_far[t - 1]
        if opens[t]:
            so_far[t] = costs[t]
        else:
            switch = np.min(before) + beta
            for k in range(n_clusters):
                so_far[t, k] = costs[t, k] + min(before[k], switch)
    for t in range(n_frames - 1, -1, -1):
        if ends[t]:
            after[:] = 0.0
        own = so_far[t, labels[t]] + after[labels[t]]
        other = np.inf
        for k in range(n_clusters):
            if k != labels[t]:
                other = min(other, so_far[t, k] + after[k])
        margins[t] = max(other - own, 0.0)
        switch = np.inf
        for k in range(n_clusters):
            after[k] += costs[t, k]
            switch = min(switch, after[k] + beta)
        for k in range(n_clusters):
            after[k] = min(after[k], switch)
