"""The train stage: tables in, a checkpoint out."""

import logging
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import torch

from mimeline import tables
from mimeline.dataset.windows import Normaliser, clips
from mimeline.training import checkpoint as checkpoints
from mimeline.training.families import FAMILIES

log = logging.getLogger(__name__)

LEAST_FRAMES = 8  # valid frames of all training clips together, below which nothing can be learnt


def train(
    model: str,
    motions: Sequence[str | Path],
    frames: Sequence[str | Path],
    split: str | Path,
    statistics: str | Path,
    checkpoint: str | Path,
    options: dict[str, Any],
    threads: int = 1,
) -> None:
    """Train a model of the family `model` on the train part and write its checkpoint folder.

    motions, frames, split, statistics: files of the tables of these names. options: the keys of
    the model's config section; threads: of torch, one is fastest for small models. On one machine
    and number of threads a seed gives the same weights. With too little data the checkpoint says
    why it is empty. Raises TrainingDiverged where the loss is not finite.
    """
    torch.set_num_threads(threads)
    parts = tables.read(tables.SPLIT, split)
    normaliser = Normaliser.from_statistics(tables.read(tables.STATISTICS, statistics))
    motion = tables.read_all(tables.MOTION, motions)
    timelines = tables.read_all(tables.FRAMES, frames)
    wanted = {part: parts.loc[parts["part"] == part, "clip_id"] for part in ("train", "val")}
    data = {part: clips(motion, timelines, normaliser, ids) for part, ids in wanted.items()}

    origin = checkpoints.provenance([*motions, *frames, split, statistics], options["seed"])
    n_frames = sum(int(clip.valid.sum()) for clip in data["train"])
    log.info("%d clips, %d valid frames to train on", len(data["train"]), n_frames)
    if partly := sum(not clip.measured.any(axis=0).all() for clip in data["train"]):
        log.info("%d of them lack a channel, which does not count in their loss", partly)
    if n_frames < LEAST_FRAMES or not normaliser.channels:
        why = f"the train part has {n_frames} valid frames of {len(normaliser.channels)} channels"
        log.warning("nothing is trained: %s", why)
        checkpoints.save_empty(checkpoint, why, origin)
        return
    family = FAMILIES[model]
    architecture = {key: options[key] for key in family.architecture}
    network = family.model(normaliser.channels, **architecture)
    run = family.train(network, data["train"], data["val"], options)
    checkpoints.save(
        checkpoint,
        run,
        family=model,
        model=architecture,
        train=options,
        normaliser=normaliser,
        origin=origin,
    )
