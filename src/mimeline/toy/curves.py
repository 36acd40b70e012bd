"""Curves over time: attack, hold and release; wander and speech through random knots."""

import math

import numpy as np


def smoothstep(x: np.ndarray) -> np.ndarray:
    """0 at 0, 1/2 at 1/2, 1 at 1, flat at both ends."""
    return x * x * (3 - 2 * x)


def envelope(attack: int, hold: int, release: int) -> np.ndarray:
    """Attack, hold and release of height 1, (attack + hold + release,).

    attack, hold, release in frames. At or above 1/2 exactly on `on_frames`.
    """
    rise = smoothstep((np.arange(attack) + 0.5) / attack)
    fall = smoothstep((np.arange(release) + 0.5) / release)[::-1]
    return np.concatenate([rise, np.ones(hold), fall])


def on_frames(attack: int, hold: int, release: int) -> tuple[int, int]:
    """The half-open interval of an envelope's frames that reach half its height."""
    return attack // 2, attack + hold + (release + 1) // 2


def through_knots(knots: np.ndarray, every: float, frames: int) -> np.ndarray:
    """A smooth curve through knots (n, ...) that lie `every` frames apart, (frames, ...).

    Needs n >= knots_for(frames, every).
    """
    at = np.arange(frames) / every
    left = at.astype(int)
    weight = smoothstep(at - left).reshape(-1, *[1] * (knots.ndim - 1))
    return knots[left] * (1 - weight) + knots[left + 1] * weight


def knots_for(frames: int, every: float) -> int:
    """How many knots `through_knots` needs."""
    return math.ceil(frames / every) + 2
