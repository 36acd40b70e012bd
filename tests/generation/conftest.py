from copy import deepcopy

import numpy as np
import pytest
import torch

from mimeline import tables
from mimeline.dataset.windows import Normaliser
from mimeline.models.timeline import TimelineModel
from mimeline.training import checkpoint as checkpoints
from mimeline.training.loop import Run

CHANNELS = ("browInnerUp", "jawOpen", "head_yaw_left")


@pytest.fixture(scope="session")
def checkpoint(tmp_path_factory):
    """A checkpoint that never learnt, but whose every weight does something."""
    torch.set_num_threads(1)
    shape = {"width": 16, "heads": 2, "base_layers": 1, "branch_layers": 1, "diffusion_steps": 100}
    model = TimelineModel(CHANNELS, **shape)
    generator = torch.Generator().manual_seed(0)
    with torch.no_grad():
        for parameter in model.parameters():
            parameter.copy_(torch.randn(parameter.shape, generator=generator) * 0.3)
    low, high = np.array([0.0, 0.0, -0.5]), np.array([1.0, 1.0, 0.5])
    normaliser = Normaliser(CHANNELS, np.array([0.3, 0.1, 0.0]), np.full(3, 0.2), low, high)
    folder = tmp_path_factory.mktemp("generation") / "checkpoint"
    run = Run(model, deepcopy(model), tables.empty(tables.LOSSES))
    facts = {"family": "timeline", "model": shape, "train": {}, "origin": {}}
    checkpoints.save(folder, run, normaliser=normaliser, **facts)
    return folder
