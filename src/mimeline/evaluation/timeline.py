"""How well generated motion follows the timelines that were asked for, and how natural it is."""

import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
import pandas as pd
import torch

from mimeline import tables
from mimeline.annotation.annotator import Annotator
from mimeline.annotation.region_model import read_models
from mimeline.annotation.scores import confusions, interval, resampled
from mimeline.annotation.thresholds import Limits
from mimeline.dataset.windows import timelines
from mimeline.evaluation.clip_motion import clip_values, motion_table, moving
from mimeline.evaluation.motion_scores import (
    Moments,
    alignment_draws,
    from_zero,
    liveliness_draws,
    motion_draws,
)
from mimeline.evaluation.unseen import choose
from mimeline.generation.request import Request
from mimeline.generation.timeline import Sampling, generate
from mimeline.training import checkpoint as checkpoints
from mimeline.vocabulary import UNKNOWN

log = logging.getLogger(__name__)

MODEL = "timeline"
Spread = Callable[[np.ndarray], tuple[float, float, float]]  # draws → value, low, high


def evaluate_timeline(
    checkpoint: str | Path,
    motions: Sequence[str | Path],
    frames: Sequence[str | Path],
    split: str | Path,
    segment_models: dict[str, Path],
    labels: str | Path,
    metrics: str | Path,
    generated: str | Path,
    annotate: Mapping[str, Any],
    resamples: int,
    options: Mapping[str, Any],
    threads: int = 1,
) -> None:
    """Ask the model for timelines of real clips, annotate what it makes, and score it.

    Writes metrics (variants request: told the timeline; empty: told that nothing happens;
    unconditional: told nothing; real: the clips themselves) and generated (`motion` of the variant
    request, under the ids of the clips whose timelines were asked for). tas is the mean, over the
    regions of which an action was asked, of the macro-F1 of request and annotation (Ma et al.
    2025, 4.2). Distances and ratios are to the real clips of the requests; those of variant real
    are the floor, from other real clips, as many where there are. A row's n is its number of clips.

    annotate: closed, gaze_deg, head_deg, min_frames; resamples: of clips, behind each interval;
    options: the keys of the sampling's config section; threads: of torch. With an empty
    checkpoint, or no annotated clip, both tables are empty and say why.
    """
    torch.set_num_threads(threads)
    rng = np.random.default_rng(options["seed"])
    marked = tables.read_all(tables.FRAMES, frames)
    part, ids, others = choose(tables.read(tables.SPLIT, split), marked, options["timelines"], rng)
    if why := checkpoints.reason(checkpoint) or ("" if ids else "no clip is annotated"):
        for table, path in ((tables.METRICS, metrics), (tables.MOTION, generated)):
            tables.write(table, tables.empty(table), path, reason=why)
        return
    if len(ids) < options["timelines"]:
        log.warning("%d timelines of the %d wanted: no more clips", len(ids), options["timelines"])
    motion = tables.read_all(tables.MOTION, motions)
    trained = checkpoints.load(checkpoint)
    channels = list(trained.normaliser.channels)
    truth = marked[marked["clip_id"].isin(ids)].reset_index(drop=True)
    asked = timelines(truth)  # sorted by clip_id, as truth is
    told = {
        "request": list(asked.values()),
        "empty": [np.where(t == UNKNOWN, UNKNOWN, 0.0) for t in asked.values()],
        "unconditional": [np.full_like(t, UNKNOWN) for t in asked.values()],
    }
    sampling = Sampling(**{f.name: options[f.name] for f in fields(Sampling)})
    named = tables.read(tables.LABELS, labels)
    annotator = Annotator(read_models(segment_models), named, Limits(**annotate))
    weights = resampled(len(ids), resamples, rng)
    rows: list[tuple] = []

    def note(variant: str, n: int, draws: Mapping[str, np.ndarray], spread: Spread) -> None:
        spreads = {metric: spread(own) for metric, own in draws.items()}
        known = {metric: own for metric, own in spreads.items() if np.isfinite(own[0])}
        rows.extend((MODEL, variant, part, m, *own, n, options["seed"]) for m, own in known.items())
        log.info("%s: %s", variant, ", ".join(f"{m} {own[0]:.4g}" for m, own in known.items()))

    def note_alignment(variant: str, table: pd.DataFrame) -> None:
        found = annotator.frames(table)
        present = np.isin(ids, found["clip_id"].unique().tolist())  # (n_clips,)
        draws = alignment_draws(confusions(truth, found), weights[:, present])
        note(variant, int(present.sum()), draws, interval)

    own, elsewhere = (clip_values(motion, chosen, channels) for chosen in (ids, others))
    real = Moments.of(own)
    note_alignment("real", motion[motion["clip_id"].isin(ids)])
    note("real", moving(own), liveliness_draws(real, weights), from_zero)
    if others:
        apart = resampled(len(others), resamples, rng)
        drawn = min(len(apart), len(weights))
        floor = motion_draws(Moments.of(elsewhere), real, apart[:drawn], weights[:drawn])
        note("real", moving(elsewhere), floor, from_zero)
    for variant, given in told.items():
        requests = [Request.both_sides(timeline) for timeline in given]
        started = perf_counter()
        clips = generate(trained, requests, sampling, options["seed"])
        seconds = perf_counter() - started
        log.info("%s: %.1f s, %.0f frames per second", variant, seconds, len(truth) / seconds)
        table = motion_table(truth, clips, channels)
        if variant == "request":
            tables.write(tables.MOTION, table, generated)
        made = Moments.of([[clip] for clip in clips])
        note_alignment(variant, table)
        note(variant, len(ids), liveliness_draws(made, weights), from_zero)
        note(variant, len(ids), motion_draws(made, real, weights), from_zero)
    table = pd.DataFrame(rows, columns=tables.METRICS.schema.names)
    tables.write(tables.METRICS, table, metrics)
