"""Fréchet distances: how far one set of frames is from another, as Gaussians."""

import numpy as np

Gaussians = tuple[np.ndarray, np.ndarray]  # means (R, D), covariances (R, D, D)


def frechet(first: np.ndarray, second: np.ndarray) -> float:
    """Squared Fréchet distance of the Gaussians fitted to (N1, D) and (N2, D) samples.

    Unit: the square of the samples'. It has a floor above 0 for two finite draws of one law, so
    give the real-to-real distance too. Raises ValueError unless both have two samples or more.
    """
    if min(len(first), len(second)) < 2:
        raise ValueError("a Fréchet distance needs two samples or more on either side")
    one, two = (
        (x.mean(axis=0)[None], np.atleast_2d(np.cov(x, rowvar=False))[None])
        for x in (first.astype(np.float64), second.astype(np.float64))
    )
    return float(gaussian_distances(one, two)[0])


def gaussian_distances(first: Gaussians, second: Gaussians) -> np.ndarray:
    """(R,) squared Fréchet distances of pairs of Gaussians; NaN where one of a pair is not known.

    |m1 − m2|² + tr C1 + tr C2 − 2 tr (C1^½ C2 C1^½)^½ (Heusel et al. 2017, equation 6), in the
    symmetric form, whose eigenvalues are real by construction.
    """
    known = np.isfinite(first[0]).all(axis=-1) & np.isfinite(second[0]).all(axis=-1)  # (R,)
    (mean, one), (other, two) = ((m[known], c[known]) for m, c in (first, second))
    apart = ((mean - other) ** 2).sum(axis=-1)  # (R,)
    values, vectors = np.linalg.eigh(one)
    root = (vectors * np.sqrt(values.clip(min=0))[:, None, :]) @ vectors.swapaxes(-1, -2)
    overlap = np.sqrt(np.linalg.eigvalsh(root @ two @ root).clip(min=0)).sum(axis=-1)  # (R,)
    traces = np.trace(one, axis1=-2, axis2=-1) + np.trace(two, axis1=-2, axis2=-1)
    distances = np.full(len(known), np.nan)
    distances[known] = np.maximum(apart + traces - 2 * overlap, 0.0)
    return distances
