"""How a movement fades over the skin."""

import numpy as np


def smoothstep(values: np.ndarray, low: float, high: float) -> np.ndarray:
    """0 up to low, 1 from high, and a cubic without corners between."""
    share = np.clip((values - low) / (high - low), 0, 1)
    return share * share * (3 - 2 * share)


def bell(points: np.ndarray, centre, size) -> np.ndarray:
    """1 at a centre (3,), 1/e at a distance of size (3,) along each axis: points (n, 3) → (n,)."""
    return np.exp(-(((points - centre) / size) ** 2).sum(-1))


def folded(points: np.ndarray) -> np.ndarray:
    """Points (n, 3) with those of the right half mirrored to the left."""
    return np.abs(points[:, :1]) * [1, 0, 0] + points * [0, 1, 1]
