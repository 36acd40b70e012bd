"""What the variants of the ablation study make of the same timelines, and how well they do."""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import torch

from mimeline import tables
from mimeline.annotation.annotator import Annotator
from mimeline.annotation.region_model import read_models
from mimeline.annotation.scores import confusions, resampled
from mimeline.annotation.thresholds import Limits
from mimeline.dataset.windows import timelines
from mimeline.evaluation.coupling import drift, gazes
from mimeline.evaluation.motion_scores import (
    Moments,
    alignment_draws,
    liveliness_draws,
    motion_draws,
)
from mimeline.evaluation.timeline import clip_values, motion_table
from mimeline.evaluation.variants import CONFLICT, UNGUIDED, UNSEEN
from mimeline.generation.request import Request
from mimeline.generation.timeline import Sampling, generate
from mimeline.training import checkpoint as checkpoints
from mimeline.vocabulary import CHANNELS

log = logging.getLogger(__name__)


def generated(
    checkpoint: str | Path,
    asked: Mapping[str, Path],
    segment_models: Mapping[str, Path],
    labels: str | Path,
    made: Mapping[str, Path],
    found: Mapping[str, Path],
    annotate: Mapping[str, Any],
    options: Mapping[str, Any],
    seed: int,
    threads: int = 1,
) -> None:
    """Write what a variant makes of the timelines that are asked for, and what is found in it.

    asked, found: by set of ASKED, a `frames` table; made: by set of MADE, a `motion` table under
    the ids of the timelines. annotate: of Limits; options: the keys of the sampling's config
    section. seed: of the noise, which is the same for all variants. Where there is no model, or
    nothing is asked, the tables say so.
    """
    torch.set_num_threads(threads)
    nothing = checkpoints.reason(checkpoint)
    guided = Sampling(**{f.name: options[f.name] for f in fields(Sampling)})
    plain = replace(guided, guidance=1.0, region_guidance={})
    limits = Limits(**annotate)
    annotator = Annotator(read_models(segment_models), tables.read(tables.LABELS, labels), limits)
    for name, path in made.items():
        wanted = asked[UNSEEN if name == UNGUIDED else name]
        if why := nothing or tables.reason(wanted):
            tables.write(tables.MOTION, tables.empty(tables.MOTION), path, why)
            marked = tables.empty(tables.FRAMES)
        else:
            told = tables.read(tables.FRAMES, wanted)
            requests = [Request.both_sides(timeline) for timeline in timelines(told).values()]
            channels = checkpoints.load(checkpoint).normaliser.channels
            sampling = plain if name == UNGUIDED else guided
            motion = motion_table(told, generate(checkpoint, requests, sampling, seed), channels)
            tables.write(tables.MOTION, motion, path)
            marked = annotator.frames(motion)
            log.info("%s: %d timelines", name, len(requests))
        if name in found:
            tables.write(tables.FRAMES, marked, found[name], why)


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
    head goes with the eyes, without guidance: that draws the gazes of a direction to one size. What
    cannot be had is absent.
    """
    draws: dict[str, np.ndarray] = {}
    if len(made[UNSEEN]):
        weights = asked.weights[UNSEEN]
        channels = [name for name in CHANNELS if made[UNSEEN][name].notna().any()]
        own, real = (
            Moments.of(clip_values(motion, asked.clips[UNSEEN], channels))
            for motion in (made[UNSEEN], asked.real)
        )
        draws |= alignment_draws(confusions(asked.frames[UNSEEN], found[UNSEEN]), weights)
        draws |= {"var": liveliness_draws(own, weights)["var"]}
        apart = motion_draws(own, real, weights)
        draws |= {name: apart[name] for name in ("fid_fm", "fid_delta_fm", "snd")}
    if len(made[CONFLICT]):
        counts = confusions(asked.frames[CONFLICT], found[CONFLICT])
        weights = asked.weights[CONFLICT]
        draws["conflict"] = asked_draws(counts, weights)
        draws["conflict_tas"] = alignment_draws(counts, weights)["tas"]
    if len(made[UNGUIDED]):
        held = gazes(asked.frames[UNSEEN], made[UNGUIDED])
        slope = drift(held, asked.clips[UNSEEN], asked.weights[UNSEEN])
        draws |= {} if slope is None else {"drift": slope}
    return draws


def _resampled(clips: Sequence[str], resamples: int, seed: Sequence[int]) -> np.ndarray:
    """`resampled`; (1, 0) where there is no clip."""
    if not clips:
        return np.ones((1, 0))
    return resampled(len(clips), resamples, np.random.default_rng(seed))


def asked_draws(counts: Mapping[str, np.ndarray], weights: np.ndarray) -> np.ndarray:
    """Mean F1 of the actions, and of neutral, that are asked for; mean over their tracks.

    counts: of `confusions`; weights (R, n_clips). Of the timelines asked for, tas counts every
    action that is found, so that one frame of an action that none of them holds halves it: a score
    for timelines that hold all actions, and not for those that hold two.
    """
    scores = []
    for own in counts.values():
        asked = own.any(axis=(0, 2))  # (C,), Neutral first
        if asked[1:].any():
            drawn = np.tensordot(weights, own, 1)  # (R, C, C)
            hits = np.diagonal(drawn, axis1=1, axis2=2)
            total = drawn.sum(axis=1) + drawn.sum(axis=2)  # (R, C)
            scores.append((2 * hits / np.maximum(total, 1))[:, asked].mean(axis=1))
    return np.mean(scores, axis=0) if scores else np.full(len(weights), np.nan)


def of_recordings(
    asked: Asked, motion: pd.DataFrame, frames: pd.DataFrame, others: Sequence[str], seed: int
) -> dict[str, np.ndarray]:
    """The same of the real clips, draws as many: what the variants are to come near.

    motion, frames: the tables of all clips; others: clips beside those whose timelines are asked
    for. var is that of the latter; fid_fm, fid_delta_fm and snd are their distances to the others,
    the floor; drift is that of all clips.
    """
    weights = asked.weights[UNSEEN]
    resamples = len(weights) - 1
    channels = [name for name in CHANNELS if motion[name].notna().any()]
    draws: dict[str, np.ndarray] = {}
    if len(asked.real):
        real = Moments.of(clip_values(motion, asked.clips[UNSEEN], channels))
        draws["var"] = liveliness_draws(real, weights)["var"]
        if len(others) > 1:
            elsewhere = Moments.of(clip_values(motion, others, channels))
            drawn = _resampled(others, resamples, [seed, 3])
            apart = motion_draws(elsewhere, real, drawn, weights)
            draws |= {name: apart[name] for name in ("fid_fm", "fid_delta_fm", "snd")}
    clips = sorted(frames["clip_id"].unique())
    drawn = _resampled(clips, resamples, [seed, 4])
    slope = drift(gazes(frames, motion), clips, drawn)
    return draws if slope is None else draws | {"drift": slope}
