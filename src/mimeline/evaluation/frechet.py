"""Fréchet distances: how far one set of frames is from another, as Gaussians."""

from collections.abc import Sequence

import numpy as np


def frechet(first: np.ndarray, second: np.ndarray) -> float:
    """Squared Fréchet distance of the Gaussians fitted to (N1, D) and (N2, D) samples.

    |m1 − m2|² + tr C1 + tr C2 − 2 tr (C1^½ C2 C1^½)^½ (Heusel et al. 2017, equation 6), in the
    symmetric form, whose eigenvalues are real by construction. Unit: the square of the samples'.
    It has a floor above 0 for two finite draws of one law, so give the real-to-real distance too.
    Raises ValueError unless both have two samples or more.
    """
    if min(len(first), len(second)) < 2:
        raise ValueError("a Fréchet distance needs two samples or more on either side")
    first, second = first.astype(np.float64), second.astype(np.float64)
    apart = first.mean(axis=0) - second.mean(axis=0)  # (D,)
    one, two = (np.atleast_2d(np.cov(x, rowvar=False)) for x in (first, second))  # (D, D) each
    root = _root(one)
    common = np.linalg.eigvalsh(root @ two @ root)  # (D,)
    overlap = np.sqrt(common.clip(min=0)).sum()
    return float(max(apart @ apart + np.trace(one) + np.trace(two) - 2 * overlap, 0.0))


def differences(clips: Sequence[np.ndarray]) -> np.ndarray:
    """x[t+1] − x[t] within each clip (L, D), of all clips, (N − clips, D)."""
    return np.concatenate([np.diff(clip, axis=0) for clip in clips])


def motion_distances(
    generated: Sequence[np.ndarray], real: Sequence[np.ndarray]
) -> dict[str, float]:
    """fid_fm on frames, fid_delta_fm on their differences, snd their sum (Ma et al. 2025, 4.2).

    generated, real: clips (L, D) in channel units.
    """
    frames = frechet(np.concatenate(generated), np.concatenate(real))
    velocity = frechet(differences(generated), differences(real))
    return {"fid_fm": frames, "fid_delta_fm": velocity, "snd": frames + velocity}


def _root(covariance: np.ndarray) -> np.ndarray:
    """The symmetric square root of a covariance (D, D)."""
    values, vectors = np.linalg.eigh(covariance)
    return (vectors * np.sqrt(values.clip(min=0))) @ vectors.T
