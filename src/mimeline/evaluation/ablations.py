"""How well the variants of the ablation study do, all on the same timelines."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from mimeline.annotation.scores import confusions, resampled
from mimeline.evaluation.clip_motion import clip_values, moving
from mimeline.evaluation.coupling import drift, gazes, pull, pulls
from mimeline.evaluation.motion_scores import (
    Moments,
    alignment_draws,
    liveliness_draws,
    motion_draws,
)
from mimeline.evaluation.variants import CONFLICT, NARROW, UNSEEN, WIDE
from mimeline.vocabulary import CHANNELS

DISTANCES = ("fid_fm", "fid_delta_fm", "snd")


@dataclass(frozen=True)
class Asked:
    """What all variants are asked for, and the resamples that all are judged on.

    frames: by set of ASKED, its `frames` table. clips: of each its clips, sorted. weights: of each,
    of `resampled`. real: the motion of the clips of UNSEEN, in their order.
    """

    frames: Mapping[str, pd.DataFrame]
    clips: Mapping[str, Sequence[str]]
    weights: Mapping[str, np.ndarray]
    real: pd.DataFrame

    @classmethod
    def of(
        cls, frames: Mapping[str, pd.DataFrame], motion: pd.DataFrame, resamples: int, seed: int
    ) -> "Asked":
        """frames: by set; motion: the `motion` of all real clips."""
        clips = {name: sorted(own["clip_id"].unique()) for name, own in frames.items()}
        weights = {
            name: _resampled(own, resamples, [seed, number])
            for number, (name, own) in enumerate(clips.items())
        }
        return cls(frames, clips, weights, motion[motion["clip_id"].isin(clips[UNSEEN])])


def scored(
    asked: Asked, made: Mapping[str, pd.DataFrame], found: Mapping[str, pd.DataFrame]
) -> dict[str, np.ndarray]:
    """The draws of each score of a variant, (1 + resamples,).

    made: by set of MADE, its `motion`; found: by set of ASKED, the `frames` found in it. tas,
    tas_<region>, var, fid_fm, fid_delta_fm and snd are those of the unseen timelines. conflict is
    `asked_draws` where smiles conflict with brows, conflict_tas the tas there; drift is how far the
    head goes with eyes that are given. What cannot be had is absent.
    """
    draws: dict[str, np.ndarray] = {}
    if len(made[UNSEEN]):
        weights = asked.weights[UNSEEN]
        channels = channels_of(made[UNSEEN])
        own, real = (
            Moments.of(clip_values(motion, asked.clips[UNSEEN], channels))
            for motion in (made[UNSEEN], asked.real)
        )
        draws |= alignment_draws(confusions(asked.frames[UNSEEN], found[UNSEEN]), weights)
        draws |= {"var": liveliness_draws(own, weights)["var"]}
        apart = motion_draws(own, real, weights)
        draws |= {name: apart[name] for name in DISTANCES}
    if len(made[CONFLICT]):
        counts = confusions(asked.frames[CONFLICT], found[CONFLICT])
        weights = asked.weights[CONFLICT]
        draws["conflict"] = asked_draws(counts, weights)
        draws["conflict_tas"] = alignment_draws(counts, weights)["tas"]
    if len(made[WIDE]):
        farther = pulls(asked.frames[UNSEEN], made[NARROW], made[WIDE])
        slope = pull(farther, asked.clips[UNSEEN], asked.weights[UNSEEN])
        draws |= {} if slope is None else {"drift": slope}
    return _known(draws)


def asked_draws(counts: Mapping[str, np.ndarray], weights: np.ndarray) -> np.ndarray:
    """Mean F1 of the actions, and of neutral, that are asked for; mean over their tracks.

    counts: of `confusions`; weights (R, n_clips). Of the timelines asked for, tas counts every
    action that is found, so that one frame of an action that none of them holds halves it: a score
    for timelines that hold all actions, and not for those that hold two. What the timelines of a
    row do not ask for counts nothing there.
    """
    scores = []
    for own in counts.values():
        drawn = np.tensordot(weights, own, 1)  # (R, C, C)
        asked = drawn.any(axis=2)  # (R, C), Neutral first
        if asked[:, 1:].any():
            hits = np.diagonal(drawn, axis1=1, axis2=2)
            total = drawn.sum(axis=1) + drawn.sum(axis=2)
            f1 = np.divide(2 * hits, total, out=np.zeros(total.shape), where=asked)
            scores.append(f1.sum(axis=1) / np.maximum(asked.sum(axis=1), 1))
    return np.mean(scores, axis=0) if scores else np.full(len(weights), np.nan)


def of_recordings(
    asked: Asked,
    motion: pd.DataFrame,
    frames: pd.DataFrame,
    others: Sequence[str],
    channels: Sequence[str],
    seed: int,
) -> tuple[dict[str, np.ndarray], dict[str, int]]:
    """The same of the real clips, draws as many: what the variants are to come near; and of how
    many clips each score is.

    motion, frames: the tables of all clips; others: clips beside those whose timelines are asked
    for; channels: those that the variants make. var is that of the latter; fid_fm, fid_delta_fm
    and snd are their distances to the others, the floor; drift is that of all clips. There is no
    tas: the timelines were found in these clips.
    """
    weights = asked.weights[UNSEEN]
    resamples = len(weights) - 1
    draws: dict[str, np.ndarray] = {}
    clips: dict[str, int] = {}
    if len(asked.real) and channels:
        values = clip_values(motion, asked.clips[UNSEEN], channels)
        real = Moments.of(values)
        draws["var"], clips["var"] = liveliness_draws(real, weights)["var"], moving(values)
        if len(others) > 1:
            values = clip_values(motion, others, channels)
            drawn = _resampled(others, resamples, [seed, 3])
            apart = motion_draws(Moments.of(values), real, drawn, weights)
            draws |= {name: apart[name] for name in DISTANCES}
            clips |= dict.fromkeys(DISTANCES, moving(values))
    every = sorted(frames["clip_id"].unique())
    slope = drift(gazes(frames, motion), every, _resampled(every, resamples, [seed, 4]))
    if slope is not None:
        draws["drift"], clips["drift"] = slope, len(every)
    return _known(draws), clips


def channels_of(motion: pd.DataFrame) -> list[str]:
    """Those that a `motion` table has values of."""
    return [name for name in CHANNELS if motion[name].notna().any()]


def _known(draws: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The scores that have a value."""
    return {name: own for name, own in draws.items() if np.isfinite(own[0])}


def _resampled(clips: Sequence[str], resamples: int, seed: Sequence[int]) -> np.ndarray:
    """`resampled`; (1, 0) where there is no clip."""
    if not clips:
        return np.ones((1, 0))
    return resampled(len(clips), resamples, np.random.default_rng(seed))
