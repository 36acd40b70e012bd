"""What a variant of the ablation study makes of the timelines that all are asked for."""

import logging
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import torch

from mimeline import tables
from mimeline.annotation.annotator import Annotator
from mimeline.annotation.region_model import read_models
from mimeline.annotation.thresholds import Limits
from mimeline.dataset.windows import timelines
from mimeline.evaluation.clip_motion import motion_table
from mimeline.evaluation.variants import UNGUIDED, UNSEEN
from mimeline.generation.request import Request
from mimeline.generation.timeline import Sampling, generate
from mimeline.training import checkpoint as checkpoints

log = logging.getLogger(__name__)


def generated(
    checkpoint: str | Path,
    asked: Mapping[str, Path],
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
    the ids of the timelines. annotate: of Limits; sampling: of Sampling. seed: of the
    noise, which is the same for all variants. Where there is no model, or
    nothing is asked, the tables say so.
    """
    torch.set_num_threads(threads)
    nothing = checkpoints.reason(checkpoint)
    guided = Sampling(**sampling)
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
            made_by = plain if name == UNGUIDED else guided
            clips = generate(checkpoint, requests, made_by, seed)
            motion = motion_table(told, clips, channels)
            tables.write(tables.MOTION, motion, path)
            marked = annotator.frames(motion)
            log.info("%s: %d timelines", name, len(requests))
        if name in found:
            tables.write(tables.FRAMES, marked, found[name], why)
