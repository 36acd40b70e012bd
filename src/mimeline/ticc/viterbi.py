"""The cheapest labelling of sequences whose every switch of cluster costs beta."""

import numpy as np
from numba import njit


@njit(cache=True)
def best_path(costs, lengths, beta):
    """Labels (T,) int64 that minimise the sum of costs + beta per switch, and that minimum.

    costs (T, K) · lengths (S,) · beta >= 0. Sequences are apart: no switch is charged between them.
    Exact in O(T K): with one price for every switch, the best predecessor of a cluster is itself or
    the cheapest of all (Hallac et al. 2017, algorithm 1). Ties stay, then take the smallest index.
    """
    n_frames, n_clusters = costs.shape
    labels = np.empty(n_frames, np.int64)
    stays = np.empty((n_frames, n_clusters), np.bool_)
    cheapest = np.empty(n_frames, np.int64)  # the cheapest cluster to have come to at t
    so_far = np.empty(n_clusters)
    total = 0.0
    start = 0
    for length in lengths:
        end = start + length
        so_far[:] = costs[start]
        cheapest[start] = np.argmin(so_far)
        for t in range(start + 1, end):
            switch = so_far[cheapest[t - 1]] + beta
            for k in range(n_clusters):
                stays[t, k] = so_far[k] <= switch
                so_far[k] = costs[t, k] + (so_far[k] if stays[t, k] else switch)
            cheapest[t] = np.argmin(so_far)
        labels[end - 1] = cheapest[end - 1]
        total += so_far[cheapest[end - 1]]
        for t in range(end - 1, start, -1):
            k = labels[t]
            labels[t - 1] = k if stays[t, k] else cheapest[t - 1]
        start = end
    return labels, total


@njit(cache=True)
def path_margins(costs, lengths, beta, labels):
    """(T,) >= 0: how much dearer the best path becomes when a frame must leave its cluster.

    Arguments as for `best_path`, labels (T,) its result. Forward and backward minima meet at every
    frame, so the figure is exact. Infinite where there is a single cluster.
    """
    n_frames, n_clusters = costs.shape
    ahead = np.zeros((n_frames, n_clusters))  # cheapest rest of the sequence after t
    start = 0
    for length in lengths:
        for t in range(start + length - 2, start - 1, -1):
            switch = np.inf
            for k in range(n_clusters):
                ahead[t, k] = ahead[t + 1, k] + costs[t + 1, k]
                switch = min(switch, ahead[t, k] + beta)
            for k in range(n_clusters):
                ahead[t, k] = min(ahead[t, k], switch)
        start += length
    margins = np.empty(n_frames)
    so_far = np.empty(n_clusters)
    start = 0
    for length in lengths:
        for t in range(start, start + length):
            if t == start:
                so_far[:] = costs[t]
            else:
                switch = np.min(so_far) + beta
                for k in range(n_clusters):
                    so_far[k] = min(so_far[k], switch) + costs[t, k]
            other = np.inf
            for k in range(n_clusters):
                if k != labels[t]:
                    other = min(other, so_far[k] + ahead[t, k])
            margins[t] = max(other - (so_far[labels[t]] + ahead[t, labels[t]]), 0.0)
        start += length
    return margins
