"""What a variant of the ablation study makes of the timelines that all are asked for."""

import logging
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import torch

from mimeline import tables
from mimeline.annotation.annotator import Annotator
from mimeline.annotation.region_model import read_models
from mimeline.annotation.thresholds import Limits
from mimeline.dataset.windows import timelines
from mimeline.evaluation.clip_motion import motion_table
from mimeline.evaluation.variants import EYES, UNSEEN
from mimeline.generation.request import Request
from mimeline.generation.timeline import Sampling, generate
from mimeline.training import checkpoint as checkpoints

log = logging.getLogger(__name__)

LOOKS = ("gaze_", "eyeLook")  # what channels of the eyes' direction begin with


def generated(
    checkpoint: str | Path,
    asked: Mapping[str, Path],
    motions: Sequence[str | Path],
    segment_models: Mapping[str, Path],
    labels: str | Path,
    made: Mapping[str, Path],
    found: Mapping[str, Path],
    annotate: Mapping[str, Any],
    sampling: Mapping[str, Any],
    seed: int,
    threads: int = 1,
) -> None:
    """Write what a variant makes of the timelines that are asked for, and what is found in it.

    asked, found: by set of ASKED, a `frames` table; made: by set of MADE, a `motion` table under
    the ids of the timelines. motions: of the clips, whose eyes those of EYES are given. annotate:
    of Limits; sampling: of Sampling. seed: of the noise, which is the same for all variants. Where
    there is no model, or nothing is asked, the tables say so.
    """
    torch.set_num_threads(threads)
    nothing = checkpoints.reason(checkpoint)
    limits = Limits(**annotate)
    annotator = Annotator(read_models(segment_models), tables.read(tables.LABELS, labels), limits)
    clips = tables.read_all(tables.MOTION, motions)
    trained = None if nothing else checkpoints.load(checkpoint)
    for name, path in made.items():
        wanted = asked[UNSEEN if name in EYES else name]
        if why := nothing or tables.reason(wanted):
            tables.write(tables.MOTION, tables.empty(tables.MOTION), path, why)
            marked = tables.empty(tables.FRAMES)
        else:
            told = tables.read(tables.FRAMES, wanted)
            channels = trained.normaliser.channels
            known = eyes(told, clips, channels, EYES[name]) if name in EYES else {}
            requests = [
                Request(timeline, timeline, known.get(clip, {}))
                for clip, timeline in timelines(told).items()
            ]
            values = generate(trained, requests, Sampling(**sampling), seed)
            motion = motion_table(told, values, channels)
            tables.write(tables.MOTION, motion, path)
            marked = annotator.frames(motion)
            log.info("%s: %d timelines", name, len(requests))
        if name in found:
            tables.write(tables.FRAMES, marked, found[name], why)


def eyes(
    frames: pd.DataFrame, motion: pd.DataFrame, channels: Collection[str], far: float
) -> dict[str, dict[str, np.ndarray]]:
    """Where each clip's eyes look, by channel, (L,) for its rows of `frames`, times `far`.

    motion: of these clips. What a clip measures of these channels in no frame is left out; between
    frames that are measured it goes straight.
    """
    looks = [name for name in channels if name.startswith(LOOKS)]
    rows = frames[["clip_id", "frame"]].merge(motion, on=["clip_id", "frame"], how="left")
    rows[looks] = rows[looks].where(rows["valid"].fillna(False).astype(bool))
    found = {}
    for clip, own in rows.groupby("clip_id"):
        measured = own[looks].astype("float64").dropna(axis="columns", how="all")
        filled = measured.interpolate(limit_direction="both") * far
        found[str(clip)] = {name: filled[name].to_numpy() for name in filled}
    return found
