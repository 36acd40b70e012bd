from copy import deepcopy
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import pandas as pd
import pytest
import torch

from mimeline import tables
from mimeline.dataset.statistics import statistics
from mimeline.dataset.windows import Normaliser
from mimeline.models.timeline import TimelineModel
from mimeline.toy.world import simulate
from mimeline.training import checkpoint as checkpoints
from mimeline.training.loop import Run

from ..tiny import ARCHITECTURE


@dataclass(frozen=True)
class World:
    """A simulated world as files, an untrained checkpoint for it and an empty one."""

    motion: Path
    frames: Path
    split: Path
    labels: Path
    untrained: Path
    empty: Path


@pytest.fixture(scope="session")
def world(tmp_path_factory) -> World:
    torch.set_num_threads(1)
    folder = tmp_path_factory.mktemp("evaluation")
    names = ("motion", "frames", "split", "labels")
    found = World(
        *(folder / f"{name}.parquet" for name in names), folder / "untrained", folder / "empty"
    )
    toy = simulate(people=3, clips=8, seed=1)
    ids = sorted(toy.frames["clip_id"].unique())
    part = ["train", "train", "train", "test", "test", "val", "val", "val"]
    tables.write(tables.MOTION, toy.motion, found.motion)
    tables.write(tables.FRAMES, toy.frames, found.frames)
    split = pd.DataFrame({"clip_id": ids, "part": part, "group": ids})
    tables.write(tables.SPLIT, split, found.split)
    tables.write(tables.LABELS, tables.empty(tables.LABELS), found.labels)

    normaliser = Normaliser.from_statistics(statistics(toy.motion))
    model = TimelineModel(normaliser.channels, **ARCHITECTURE)
    model.initialise(torch.Generator().manual_seed(0))
    run = Run(model, deepcopy(model), tables.empty(tables.LOSSES))
    facts = {"family": "timeline", "model": ARCHITECTURE, "train": {"window": 64}}
    facts |= {"fps": Fraction(30), "origins": {}, "origin": {}}
    checkpoints.save(found.untrained, run, normaliser=normaliser, **facts)
    checkpoints.save_empty(found.empty, "the train part is empty", {})
    return found
