"""The train stage: tables in, a checkpoint out."""

import logging
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import pandas as pd
import torch

from mimeline import tables
from mimeline.dataset.windows import Normaliser
from mimeline.dataset.windows import clips as as_clips
from mimeline.errors import BadFile
from mimeline.room import room
from mimeline.tracking.origins import told
from mimeline.training import checkpoint as checkpoints
from mimeline.training.families import FAMILIES
from mimeline.training.hardware import Hardware
from mimeline.training.processes import together
from mimeline.training.state import key

log = logging.getLogger(__name__)

LEAST_FRAMES = 8  # valid frames of all training clips together, below which nothing can be learnt


def train(
    *,
    model: str,
    motions: Sequence[str | Path],
    frames: Sequence[str | Path],
    clips: Sequence[str | Path],
    origins: Sequence[str | Path],
    split: str | Path,
    statistics: str | Path,
    checkpoint: str | Path,
    options: Mapping[str, Any],
    hardware: Mapping[str, Any],
    state: str | Path | None = None,
    tensorboard: str | Path | None = None,
    code: str = "",
    threads: int = 1,
) -> None:
    """Train a model of the family `model` on the train part and write its checkpoint folder.

    motions, frames, clips, origins, split, statistics: files of the tables of these names. options:
    the keys of the model's config section. hardware: those of `Hardware`. threads: of torch, shared
    by all processes; one is fastest for small models. state, tensorboard: folders of the model's
    trainings, for what resumes one and for curves; each training, which is told by its data,
    options, precision and code (a digest), has its own in there. Once the checkpoint stands where
    it should, `finished` removes the state.

    On one machine and number of threads a seed gives the same weights, also of a training that was
    interrupted. With too little data the checkpoint says why it is empty. Raises TrainingDiverged
    where the loss is not finite, NoRoom where a disk is full, BadConfig where this machine lacks
    the hardware.
    """
    torch.set_num_threads(threads)
    place = Hardware(**hardware)
    parts = tables.read(tables.SPLIT, split)
    normaliser = Normaliser.from_statistics(tables.read(tables.STATISTICS, statistics))
    motion = tables.read_all(tables.MOTION, motions)
    timelines = tables.read_all(tables.FRAMES, frames)
    wanted = {part: parts.loc[parts["part"] == part, "clip_id"] for part in ("train", "val")}
    data = {part: as_clips(motion, timelines, normaliser, ids) for part, ids in wanted.items()}

    origin = checkpoints.provenance(
        [*motions, *frames, *clips, *origins, split, statistics], options["seed"]
    )
    n_frames = sum(int(clip.valid.sum()) for clip in data["train"])
    log.info("%d clips, %d valid frames to train on", len(data["train"]), n_frames)
    if partly := sum(not clip.measured.any(axis=0).all() for clip in data["train"]):
        log.info("%d of them lack a channel, which does not count in their loss", partly)
    if n_frames < LEAST_FRAMES or not normaliser.channels:
        why = f"the train part has {n_frames} valid frames of {len(normaliser.channels)} channels"
        log.warning("nothing is trained: %s", why)
        checkpoints.save_empty(checkpoint, why, origin)
        return
    fps = frame_rate(tables.read_all(tables.CLIPS, clips), {clip.clip_id for clip in data["train"]})

    family = FAMILIES[model]
    architecture = {name: options[name] for name in family.architecture}
    own = key(
        family=model,
        options={name: value for name, value in options.items() if name != "save_every"},
        precision=place.precision,
        data=[file["sha256"] for file in origin["inputs"]],
        packages=origin["packages"],
        code=[origin["mimeline"], code],
    )
    run = together(
        place.processes,
        "nccl" if place.on_cuda else "gloo",
        family.train,
        family.model(normaliser.channels, **architecture),
        data["train"],
        data["val"],
        dict(options),
        place,
        state and Path(state, own),
        tensorboard and Path(tensorboard, own),
    )
    with room(Path(checkpoint).parent, "the checkpoint"):
        checkpoints.save(
            checkpoint,
            run,
            family=model,
            model=architecture,
            train=options,
            normaliser=normaliser,
            fps=fps,
            origins=told(tables.read_all(tables.ORIGINS, origins)),
            origin=origin,
        )


def frame_rate(clips: pd.DataFrame, wanted: Collection[str]) -> Fraction:
    """The most frequent frame rate of the wanted clips, the highest of several; the log warns
    where they differ.

    clips: the table's clip_id, fps_num, fps_den. Raises BadFile where no rate is known.
    """
    known = clips[clips["clip_id"].isin(list(wanted))].dropna(subset=["fps_num", "fps_den"])
    count = Counter(Fraction(int(c.fps_num), int(c.fps_den)) for c in known.itertuples())
    if not count:
        raise BadFile(
            "the clips of the pose stage",
            found="no frame rate of any training clip",
            expected="fps_num and fps_den",
            remedy="Run the stages from ingest on again.",
        )
    rate = max(count, key=lambda own: (count[own], own))
    if len(count) > 1:
        told = ", ".join(f"{own} fps ({count[own]})" for own in sorted(count))
        log.warning("the clips differ in frame rate: %s; the model is told %s", told, rate)
    return rate
