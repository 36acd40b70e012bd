"""How well generated motion follows the timelines that were asked for, and how natural it is."""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import torch

from mimeline import tables
from mimeline.annotation.annotator import Annotator
from mimeline.annotation.region_model import read_models
from mimeline.annotation.runs import run_starts
from mimeline.annotation.scores import bootstrap, confusions
from mimeline.annotation.thresholds import Limits
from mimeline.dataset.windows import timelines
from mimeline.evaluation.frechet import differences, motion_distances
from mimeline.generation.request import Request
from mimeline.generation.timeline import Sampling, generate
from mimeline.training import checkpoint as checkpoints
from mimeline.vocabulary import CHANNELS, UNKNOWN

log = logging.getLogger(__name__)

LEAST_UNSEEN = 4  # fewer clips kept out of training say little: then training clips are added
MODEL = "timeline"


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
    2025, 4.2), its interval by resampling clips. Fréchet distances are to the real clips of the
    requests; those of variant real are the floor, from as many other real clips. velocity is the
    mean size of a frame's change, var the mean variance, over channels.

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
    motion = tables.read_all(tables.MOTION, motions)
    channels = list(checkpoints.load(checkpoint).normaliser.channels)
    truth = marked[marked["clip_id"].isin(ids)].reset_index(drop=True)
    asked = timelines(truth)  # sorted by clip_id, as truth is
    told = {
        "request": list(asked.values()),
        "empty": [np.where(t == UNKNOWN, UNKNOWN, 0.0) for t in asked.values()],
        "unconditional": [np.full_like(t, UNKNOWN) for t in asked.values()],
    }
    sampling = Sampling(**{f.name: options[f.name] for f in fields(Sampling)})
    real = clip_values(motion, ids, channels)
    elsewhere = clip_values(motion, others, channels)
    named = tables.read(tables.LABELS, labels)
    annotator = Annotator(read_models(segment_models), named, Limits(**annotate))
    rows: list[tuple] = []

    def note(variant: str, values: Mapping[str, tuple | float]) -> None:
        for metric, value in values.items():
            spread = value if isinstance(value, tuple) else (value, None, None)
            rows.append((MODEL, variant, part, metric, *spread, len(ids), options["seed"]))

    if real:
        note("real", liveliness(real))
    if real and elsewhere:
        note("real", motion_distances(elsewhere, real))
    for variant, given in told.items():
        requests = [Request.both_sides(timeline) for timeline in given]
        made = generate(checkpoint, requests, sampling, options["seed"])
        table = motion_table(truth, made, channels)
        if variant == "request":
            tables.write(tables.MOTION, table, generated)
        scores = alignment(truth, annotator.frames(table), resamples, rng)
        note(variant, scores)
        note(variant, liveliness(made))
        if real:
            note(variant, motion_distances(made, real))
        log.info("%s: %s", variant, ", ".join(f"{k} {v[0]:.3f}" for k, v in scores.items()))
    table = pd.DataFrame(rows, columns=tables.METRICS.schema.names)
    tables.write(tables.METRICS, table, metrics)


def choose(
    split: pd.DataFrame, frames: pd.DataFrame, wanted: int, rng: np.random.Generator
) -> tuple[str, list[str], list[str]]:
    """The clips whose timelines are asked for: of the test part, then val.

    Training clips are added only where the others are fewer than LEAST_UNSEEN. Returns the parts
    used ("test+val"), at most `wanted` clip ids, and as many other ids to compare with.
    """
    annotated = frames["clip_id"].unique()
    split = split[split["clip_id"].isin(annotated)]
    found: list[str] = []
    used: list[str] = []
    rest: list[str] = []
    for part in ("test", "val", "train"):
        own = rng.permutation(sorted(split.loc[split["part"] == part, "clip_id"])).tolist()
        enough = LEAST_UNSEEN if part == "train" else wanted
        taken = own[: wanted - len(found)] if len(found) < min(enough, wanted) else []
        if taken:
            used.append(part)
        found += taken
        rest = [*own[len(taken) :], *rest]  # training clips first: there are most of them
    return "+".join(used) or "none", sorted(found), sorted(rest[: len(found)])


def clip_values(
    motion: pd.DataFrame, ids: Sequence[str], channels: Sequence[str]
) -> list[np.ndarray]:
    """The stretches of valid frames of these clips, (L, D) each, at least two frames long.

    A frame counts where every channel was measured. A clip that lacks a channel altogether is left
    out, since a Fréchet distance needs them all: the log says how many.
    """
    motion = motion[motion["clip_id"].isin(ids) & motion["valid"].astype(bool)]
    measured = motion[list(channels)].notna()
    whole = measured.groupby(motion["clip_id"]).any().all(axis=1)  # by clip
    if not whole.all():
        log.warning(
            "%d of %d real clips lack a channel of the model: nothing is compared with them",
            (~whole).sum(),
            len(whole),
        )
    frames = motion[measured.all(axis=1)]
    values = frames[list(channels)].to_numpy(np.float64)
    pieces = np.split(values, run_starts(frames)[1:])
    return [piece for piece in pieces if len(piece) > 1]


def motion_table(
    frames: pd.DataFrame, made: Sequence[np.ndarray], channels: Sequence[str]
) -> pd.DataFrame:
    """Generated motion, (L, D) per clip in the order of frames, as a `motion` table."""
    absent = dict.fromkeys([c for c in CHANNELS if c not in channels], np.nan)
    facts = {"valid": True, "confidence": np.nan, "tracker_loss": np.nan}
    values = pd.DataFrame(np.concatenate(made), columns=list(channels))
    table = pd.concat([frames[["clip_id", "frame"]], values], axis=1).assign(**facts, **absent)
    return table[tables.MOTION.schema.names]


def alignment(
    truth: pd.DataFrame, annotated: pd.DataFrame, resamples: int, rng: np.random.Generator
) -> dict[str, tuple[float, float, float]]:
    """tas and tas_<region>: value and 95 % interval over clips.

    truth, annotated: `frames` tables. The resampled clips are the same for every region.
    """
    scores = bootstrap(confusions(truth, annotated), resamples, rng)
    return {"tas" if name == "mean" else f"tas_{name}": score for name, score in scores.items()}


def liveliness(clips: Sequence[np.ndarray]) -> dict[str, float]:
    """var: mean variance, velocity: mean size of a frame's change; clips (L, D), channel units."""
    frames = np.concatenate(clips)
    return {
        "var": float(frames.var(axis=0).mean()),
        "velocity": float(np.abs(differences(clips)).mean()),
    }
