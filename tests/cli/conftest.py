from copy import deepcopy
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
import torch

from mimeline import tables
from mimeline.dataset.windows import Normaliser
from mimeline.models.timeline import TimelineModel
from mimeline.run import remember
from mimeline.tracking.take import Origin
from mimeline.training import checkpoint as checkpoints
from mimeline.training.loop import Run

from ..tiny import ARCHITECTURE

WINDOW, FPS = 32, Fraction(25)
CHANNELS = ("browInnerUp", "mouthSmileLeft", "mouthSmileRight", "head_yaw_left")
ORIGINS = {
    "browInnerUp": Origin("column BrowInnerUp"),
    "mouthSmileLeft": Origin("expression through a face", quality=0.3),
}


@pytest.fixture(scope="session")
def results(tmp_path_factory) -> Path:
    """A run's results with a small model that never learnt; the run asks it in three calls."""
    torch.set_num_threads(1)
    results = tmp_path_factory.mktemp("cli") / "results"
    model = TimelineModel(CHANNELS, **ARCHITECTURE).eval().requires_grad_(False)
    generator = torch.Generator().manual_seed(0)
    for parameter in model.parameters():
        parameter.copy_(torch.randn(parameter.shape, generator=generator) * 0.3)
    checkpoints.save(
        results / "train" / "timeline" / "checkpoint",
        Run(model, deepcopy(model), tables.empty(tables.LOSSES)),
        family="timeline",
        model=ARCHITECTURE,
        train={"window": WINDOW},
        normaliser=Normaliser(CHANNELS, *(np.full(len(CHANNELS), x) for x in (0.4, 0.2, 0, 1))),
        fps=FPS,
        origins=ORIGINS,
        origin={},
    )
    remember(results, {"evaluate": {"timeline": {"sampler_steps": 3}}}, [], [])
    return results
