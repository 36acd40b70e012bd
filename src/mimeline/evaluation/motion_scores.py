"""How natural motion is and how well it is aligned, on all clips and on resampled ones.

Every score is computed from sums over each clip, so that a resample of clips is a weighted sum.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from mimeline.annotation.scores import mean_draws
from mimeline.evaluation.frechet import gaussian_distances


@dataclass(frozen=True)
class Sums:
    """Sums over the samples (N, D) of each clip: their number, x and x xᵀ.

    count (n_clips,) · first (n_clips, D) · second (n_clips, D, D).
    """

    count: np.ndarray
    first: np.ndarray
    second: np.ndarray

    @classmethod
    def of(cls, clips: Sequence[np.ndarray]) -> Self:
        """clips: the samples of each, (N, D)."""
        return cls(
            np.array([len(x) for x in clips], dtype=np.float64),
            np.array([x.sum(axis=0) for x in clips]),
            np.array([x.T @ x for x in clips]),
        )

    def gaussians(self, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Means (R, D) and covariances (R, D, D) of the samples, each clip as often as weighed.

        weights (R, n_clips). NaN where fewer than two samples are left.
        """
        count = weights @ self.count  # (R,)
        count = np.where(count < 2, np.nan, count)
        mean = weights @ self.first / count[:, None]  # (R, D)
        second = np.tensordot(weights, self.second, 1)  # (R, D, D)
        outer = mean[:, :, None] * mean[:, None, :] * count[:, None, None]
        return mean, (second - outer) / (count - 1)[:, None, None]


@dataclass(frozen=True)
class Moments:
    """What the scores of clips need: sums over frames, over their first and third differences.

    frames, velocity: of x[t] and x[t+1] − x[t] · speed, jerk (n_clips, 2): the sum of the sizes of
    the first and of the third differences, and how many numbers these are.
    """

    frames: Sums
    velocity: Sums
    speed: np.ndarray
    jerk: np.ndarray

    @classmethod
    def of(cls, clips: Sequence[Sequence[np.ndarray]]) -> Self:
        """clips: of each its stretches of consecutive frames, (L, D) in channel units.

        A clip of which nothing is known is an empty stretch, (0, D).
        """

        def differences(order: int) -> list[np.ndarray]:
            own = [[np.diff(stretch, order, axis=0) for stretch in clip] for clip in clips]
            return [np.concatenate(stretches, dtype=np.float64) for stretches in own]

        speed, jerk = (
            np.array([(np.abs(x).sum(), x.size) for x in differences(order)]).reshape(-1, 2)
            for order in (1, 3)
        )
        return cls(Sums.of(differences(0)), Sums.of(differences(1)), speed, jerk)


def motion_draws(
    made: Moments, real: Moments, weights: np.ndarray, real_weights: np.ndarray | None = None
) -> dict[str, np.ndarray]:
    """How far made motion is from real motion; metric → (R,), NaN where too little is drawn.

    fid_fm is the squared Fréchet distance of frames, fid_delta_fm of their differences, snd the sum
    of both (Ma et al. 2025, 4.2); velocity_ratio and jerk_ratio are made / real of the mean sizes.

    weights (R, n_clips): of `resampled`, for clips of made and real that belong together;
    real_weights: those of the real clips, where they do not.
    """
    other = weights if real_weights is None else real_weights
    frames = gaussian_distances(made.frames.gaussians(weights), real.frames.gaussians(other))
    velocity = gaussian_distances(made.velocity.gaussians(weights), real.velocity.gaussians(other))
    return {
        "fid_fm": frames,
        "fid_delta_fm": velocity,
        "snd": frames + velocity,
        "velocity_ratio": _ratio(_mean(made.speed, weights), _mean(real.speed, other)),
        "jerk_ratio": _ratio(_mean(made.jerk, weights), _mean(real.jerk, other)),
    }


def liveliness_draws(clips: Moments, weights: np.ndarray) -> dict[str, np.ndarray]:
    """How much clips move; metric → (R,), NaN where too little is drawn.

    var: the mean variance of a channel over all frames; velocity and jerk: the mean sizes of the
    first and of the third difference of frames.
    """
    count = np.maximum(weights @ clips.frames.count, 1)  # (R,)
    covariances = clips.frames.gaussians(weights)[1]  # (R, D, D)
    variance = np.diagonal(covariances, axis1=1, axis2=2).mean(axis=1)  # (R,)
    return {
        "var": variance * (count - 1) / count,
        "velocity": _mean(clips.speed, weights),
        "jerk": _mean(clips.jerk, weights),
    }


def alignment_draws(counts: Mapping[str, np.ndarray], weights: np.ndarray) -> dict[str, np.ndarray]:
    """tas and tas_<region>: metric → (R,); tas: of the regions of which an action was asked.

    counts: `confusions` of what was asked and what was found; weights: of `resampled`.
    """
    draws = mean_draws(counts, weights)
    return {"tas" if name == "mean" else f"tas_{name}": own for name, own in draws.items()}


def spread(draws: np.ndarray) -> tuple[float, float, float]:
    """(value, low, high): a score on all clips and its 95 % interval, centred on the value.

    draws (1 + resamples,): the score, or the difference of two, in the order of `resampled`.

    value ± 1.96 standard deviations of the draws. Percentiles would not do: clips drawn twice make
    a sample narrower than it is, and so its Fréchet distance larger.
    """
    known = draws[1:][np.isfinite(draws[1:])]
    half = 1.96 * float(known.std(ddof=1)) if len(known) > 1 else np.nan
    return float(draws[0]), float(draws[0]) - half, float(draws[0]) + half


def from_zero(draws: np.ndarray) -> tuple[float, float, float]:
    """`spread` of a score that is never below 0."""
    value, low, high = spread(draws)
    return value, max(low, 0.0) if np.isfinite(low) else low, high


def _mean(sizes: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """(R,) of sums and counts (n_clips, 2)."""
    total, count = (weights @ sizes).T
    return _ratio(total, count)


def _ratio(part: np.ndarray, whole: np.ndarray) -> np.ndarray:
    return np.divide(part, whole, out=np.full(np.shape(part), np.nan), where=whole > 0)
