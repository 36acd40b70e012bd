"""Macro-F1 of annotated frames against the truth (Ma et al. 2025, 4.1), per region."""

from collections.abc import Collection

import numpy as np
import pandas as pd

from mimeline.annotation.annotate import track_codes, unmeasured_actions
from mimeline.vocabulary import track_actions

REGION_TRACKS: dict[str, tuple[str, ...]] = {
    "brow": ("brow",),
    "eye": ("lid",),  # on frames whose eye is not closed in truth
    "closure": ("closure",),
    "mouth": ("mouth",),
    "gaze": ("gaze_h", "gaze_v"),
    "head": ("head_h", "head_v"),
}


def region_scores(truth: pd.DataFrame, predicted: pd.DataFrame) -> dict[str, float]:
    """Macro-F1 of each region that both tables measure.

    truth, predicted: `frames` tables; frames that only one of them has are left out. A region of
    two tracks (gaze, head) scores their mean.
    """
    return _region_means({t: c.sum(axis=0) for t, c in confusions(truth, predicted).items()})


def confusions(truth: pd.DataFrame, predicted: pd.DataFrame) -> dict[str, np.ndarray]:
    """Confusion counts (n_clips, C, C) of each measured track, truth in rows, Neutral first.

    An action that one of the tables does not measure is left out, and so are the frames in which
    the other shows it: the score is that of what both can tell.
    """
    both = truth.merge(predicted, on=["clip_id", "frame"], suffixes=("_true", "_pred"))
    clips, clip = np.unique(both["clip_id"].to_numpy(str), return_inverse=True)
    counts = {}
    for track in dict.fromkeys(t for tracks in REGION_TRACKS.values() for t in tracks):
        sides = _side(both, "_true"), _side(both, "_pred")
        absent = {name for side in sides for name in unmeasured_actions(side, track)}
        if len(absent) == len(track_actions(track)):
            continue
        true = true_codes(sides[0], track, absent)
        pred = track_codes(sides[1], track, absent)
        out = [number for number, a in enumerate(track_actions(track), start=1) if a in absent]
        usable = (true >= 0) & (pred >= 0) & ~np.isin(true, out) & ~np.isin(pred, out)
        if not usable.any():
            continue
        size = len(track_actions(track)) + 1
        flat = (clip[usable] * size + true[usable]) * size + pred[usable]
        table = np.bincount(flat, minlength=len(clips) * size * size)
        counts[track] = table.reshape(len(clips), size, size)
    return counts


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
    drawn = rng.multinomial(clips, np.full(clips, 1 / clips), size=resamples)
    weights = np.concatenate([np.ones((1, clips), drawn.dtype), drawn])  # (1 + resamples, clips)
    draws = _region_means({t: np.einsum("rn,nij->rij", weights, c) for t, c in counts.items()})
    telling = [region for region in draws if _shows_an_action(counts, region)] or list(draws)
    regions = np.array([draws[region] for region in telling])  # (regions, 1 + resamples)
    known = np.maximum(np.isfinite(regions).sum(axis=0), np.finfo(float).tiny)
    mean = np.where(known < 1, np.nan, np.nansum(regions, axis=0) / known)
    return {
        region: (float(f1[0]), *(float(q) for q in np.nanquantile(f1[1:], [0.025, 0.975])))
        for region, f1 in {"mean": mean, **draws}.items()
    }


def _shows_an_action(counts: dict[str, np.ndarray], region: str) -> bool:
    """Whether truth holds an action of the region; Neutral is class 0."""
    return any(counts[track][:, 1:].any() for track in REGION_TRACKS[region] if track in counts)


def _region_means(confusion: dict[str, np.ndarray]) -> dict:
    means = {}
    for region, tracks in REGION_TRACKS.items():
        counts = [confusion[track] for track in tracks if track in confusion]
        if measured := [np.where(c.any(axis=(-2, -1)), macro_f1(c), np.nan) for c in counts]:
            means[region] = np.mean(measured, axis=0)
    return means


def _side(both: pd.DataFrame, suffix: str) -> pd.DataFrame:
    return both.rename(columns=lambda name: name.removesuffix(suffix))
