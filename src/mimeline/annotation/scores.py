"""Macro-F1 of annotated frames against the truth (Ma et al. 2025, 4.1), per region."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import pandas as pd

from mimeline.annotation.annotate import track_codes, unmeasured_actions
from mimeline.vocabulary import TRACKS, track_actions

T = TypeVar("T")

REGION_TRACKS: dict[str, tuple[str, ...]] = {
    "brow": ("brow",),
    "eye": ("lid",),  # on frames whose eye is not closed in truth
    "closure": ("closure",),
    "mouth": ("mouth",),
    "gaze": ("gaze_h", "gaze_v"),
    "head": ("head_h", "head_v"),
}


@dataclass(frozen=True)
class Judged:
    """A track on the frames that truth and annotation both have, sorted by clip and frame.

    n_clips · clip (n_frames,) their number, frame (n_frames,) · true, found (n_frames,) the classes
    of `track_codes` · counts (n_frames,) bool: whether both sides tell what the frame shows.
    """

    n_clips: int
    clip: np.ndarray
    frame: np.ndarray
    true: np.ndarray
    found: np.ndarray
    counts: np.ndarray


def judged(truth: pd.DataFrame, predicted: pd.DataFrame) -> dict[str, Judged]:
    """Each track of which a frame counts. truth, predicted: `frames` tables, in any order.

    An action that one of the tables does not measure is left out, and so are the frames in which
    the other shows it: what is judged is what both can tell. The lid does not count where the eye
    is closed in truth.
    """
    keys = ["clip_id", "frame"]
    both = truth.merge(predicted, on=keys, suffixes=("_true", "_pred")).sort_values(keys)
    clips, clip = np.unique(both["clip_id"].to_numpy(str), return_inverse=True)
    frame = both["frame"].to_numpy("int64")
    sides = _side(both, "_true"), _side(both, "_pred")
    found = {}
    for track in TRACKS:
        absent = {a for table in (truth, predicted) for a in unmeasured_actions(table, track)}
        if len(absent) == len(track_actions(track)):
            continue
        true = true_codes(sides[0], track, absent)
        pred = track_codes(sides[1], track, absent)
        out = [number for number, a in enumerate(track_actions(track), start=1) if a in absent]
        counts = (true >= 0) & (pred >= 0) & ~np.isin(true, out) & ~np.isin(pred, out)
        if counts.any():
            classes = true.astype("int8"), pred.astype("int8")
            found[track] = Judged(len(clips), clip, frame, *classes, counts)
    return found


def confusion_counts(tracks: Mapping[str, Judged]) -> dict[str, np.ndarray]:
    """(n_clips, C, C) of each track: the frames that count, truth in rows, Neutral first."""
    counts = {}
    for track, own in tracks.items():
        size = len(track_actions(track)) + 1
        row = own.clip[own.counts] * size + own.true[own.counts]
        flat = np.bincount(row * size + own.found[own.counts], minlength=own.n_clips * size * size)
        counts[track] = flat.reshape(own.n_clips, size, size)
    return counts


def confusions(truth: pd.DataFrame, predicted: pd.DataFrame) -> dict[str, np.ndarray]:
    """`confusion_counts` of what is `judged` of two `frames` tables."""
    return confusion_counts(judged(truth, predicted))


def region_scores(truth: pd.DataFrame, predicted: pd.DataFrame) -> dict[str, float]:
    """Macro-F1 of each region that both tables measure.

    truth, predicted: `frames` tables; frames that only one of them has are left out. A region of
    two tracks (gaze, head) scores their mean.
    """
    return _region_means({t: c.sum(axis=0) for t, c in confusions(truth, predicted).items()})


def true_codes(truth: pd.DataFrame, track: str, unmeasured: Collection[str] = ()) -> np.ndarray:
    """(n_frames,) the class of each frame of truth, as `track_codes`; -1 where it does not count.

    The lid does not count where the eye is closed.
    """
    codes = track_codes(truth, track, unmeasured)
    if track == "lid":
        codes[track_codes(truth, "closure") == 1] = -1
    return codes


def cluster_votes(clusters, codes, n_clusters: int, track: str) -> np.ndarray:
    """(K, C): how many frames of each cluster truth has in each class, Neutral first.

    clusters (n_frames,), codes (n_frames,) of `true_codes`.
    """
    votes = np.zeros((n_clusters, len(track_actions(track)) + 1), dtype="int64")
    counted = codes >= 0
    np.add.at(votes, (clusters[counted], codes[counted]), 1)
    return votes


def macro_f1(confusion: np.ndarray) -> np.ndarray:
    """(..., C, C) counts → (...) mean F1 of the classes that occur in truth or prediction."""
    hits = np.diagonal(confusion, axis1=-2, axis2=-1)  # (..., C)
    total = confusion.sum(axis=-1) + confusion.sum(axis=-2)  # (..., C)
    f1 = np.divide(2 * hits, total, out=np.zeros(total.shape), where=total > 0)
    return f1.sum(axis=-1) / np.maximum((total > 0).sum(axis=-1), 1)


def resampled(n_clips: int, resamples: int, rng: np.random.Generator) -> np.ndarray:
    """(1 + resamples, n_clips): how often each clip counts; first each once, then as drawn.

    Of one clip nothing is drawn, (1, 1): it tells nothing of others, and has no interval.

    A score's draws are the score of the per-clip counts that each row weighs: scores with the same
    rows are of the same clips (Efron & Tibshirani 1993, chapter 13: the percentile interval).
    """
    resamples = resamples if n_clips > 1 else 0
    drawn = rng.multinomial(n_clips, np.full(n_clips, 1 / n_clips), size=resamples)
    return np.concatenate([np.ones((1, n_clips)), drawn])


def interval(draws: np.ndarray) -> tuple[float, float, float]:
    """(value, low, high): a score on all clips and its 95 % interval.

    draws (1 + resamples,): the score in the order of `resampled`, NaN where it has no value.
    """
    known = draws[1:][np.isfinite(draws[1:])]
    low, high = np.quantile(known, [0.025, 0.975]) if len(known) else (np.nan, np.nan)
    return float(draws[0]), float(low), float(high)


def region_draws(counts: Mapping[str, np.ndarray], weights: np.ndarray) -> dict[str, np.ndarray]:
    """Region → (1 + resamples,) macro-F1, NaN where the clips drawn have no frame of it.

    counts: of `confusion_counts`; weights: of `resampled`.
    """
    return _region_means({t: np.tensordot(weights, c, 1) for t, c in counts.items()})


def bootstrap(
    counts: dict[str, np.ndarray], resamples: int, rng: np.random.Generator
) -> dict[str, tuple[float, float, float]]:
    """The "mean" of the regions' macro-F1 and each region's, with 95 % intervals over clips.

    counts: of `confusions`. Returns region → (value, low, high); resamples whose clips have no
    frame of a region do not count for it. A region in which truth holds no action at all says
    little and does not count in the mean. Empty where nothing is measured.
    """
    clips = max((len(c) for c in counts.values()), default=0)
    if not clips:
        return {}
    draws = mean_draws(counts, resampled(clips, resamples, rng))
    return {region: interval(f1) for region, f1 in draws.items()}


def mean_draws(counts: Mapping[str, np.ndarray], weights: np.ndarray) -> dict[str, np.ndarray]:
    """`region_draws`, and before them the "mean" of the regions in which truth holds an action.

    Where it holds none at all, the mean is that of all regions; empty where nothing is measured.
    """
    if not (draws := region_draws(counts, weights)):
        return {}
    telling = [region for region in draws if _shows_an_action(counts, region)] or list(draws)
    regions = np.array([draws[region] for region in telling])  # (regions, 1 + resamples)
    known = np.maximum(np.isfinite(regions).sum(axis=0), np.finfo(float).tiny)
    mean = np.where(known < 1, np.nan, np.nansum(regions, axis=0) / known)
    return {"mean": mean, **draws}


def of_region(region: str, tracks: Mapping[str, T]) -> list[T]:
    """What a mapping by track has of a region's tracks."""
    return [tracks[track] for track in REGION_TRACKS[region] if track in tracks]


def _shows_an_action(counts: Mapping[str, np.ndarray], region: str) -> bool:
    """Whether truth holds an action of the region; Neutral is class 0."""
    return any(own[:, 1:].any() for own in of_region(region, counts))


def _region_means(confusion: Mapping[str, np.ndarray]) -> dict:
    means = {}
    for region in REGION_TRACKS:
        counts = of_region(region, confusion)
        if measured := [np.where(c.any(axis=(-2, -1)), macro_f1(c), np.nan) for c in counts]:
            means[region] = np.mean(measured, axis=0)
    return means


def _side(both: pd.DataFrame, suffix: str) -> pd.DataFrame:
    return both.rename(columns=lambda name: name.removesuffix(suffix))
