from collections.abc import Callable
from copy import deepcopy
from fractions import Fraction

import numpy as np
import pytest
import torch

from mimeline import tables
from mimeline.config.sections import TimelineModel as Options
from mimeline.config.sections import TimelineSampling
from mimeline.dataset.windows import Clip, Normaliser
from mimeline.generation.timeline import Sampling
from mimeline.models.timeline import TimelineModel
from mimeline.training import checkpoint as checkpoints
from mimeline.training.families import FAMILIES
from mimeline.training.loop import Run
from mimeline.training.timeline import train_timeline
from mimeline.vocabulary import ACTIONS

WINDOW = 16
SMALL = {
    "window": WINDOW,
    "width": 16,
    "heads": 2,
    "base_layers": 1,
    "branch_layers": 1,
    "diffusion_steps": 100,
}
CHANNELS = ("browInnerUp", "browOuterUpLeft", "browOuterUpRight", "jawLeft", "head_yaw_left")


@pytest.fixture(scope="session", autouse=True)
def one_thread():
    """Threads only wait for each other on models this small."""
    torch.set_num_threads(1)


def shape(**changes) -> dict:
    """The model's plain values, those of SMALL and the config's defaults."""
    options = Options(**SMALL | changes).model_dump()
    return {key: options[key] for key in FAMILIES["timeline"].architecture}


@pytest.fixture(scope="session")
def sampling() -> Callable[..., Sampling]:
    """Four calls of the denoiser, else the config's defaults and what is given."""

    def with_changes(**changes) -> Sampling:
        options = TimelineSampling(**{"sampler_steps": 4} | changes).model_dump()
        return Sampling(**{key: options[key] for key in Sampling.__annotations__})

    return with_changes


@pytest.fixture(scope="session")
def lively() -> TimelineModel:
    """A model that never learnt, but whose every weight does something."""
    model = TimelineModel(CHANNELS, **shape()).eval().requires_grad_(False)
    generator = torch.Generator().manual_seed(0)
    for parameter in model.parameters():
        parameter.copy_(torch.randn(parameter.shape, generator=generator) * 0.3)
    return model


@pytest.fixture(scope="session")
def trained(lively, tmp_path_factory):
    """The lively model from a checkpoint; values are held within [0.3, 0.5]."""
    normaliser = Normaliser(CHANNELS, *(np.full(5, x) for x in (0.4, 0.2, 0.3, 0.5)))
    folder = tmp_path_factory.mktemp("generation") / "checkpoint"
    run = Run(lively, deepcopy(lively), tables.empty(tables.LOSSES))
    checkpoints.save(
        folder,
        run,
        family="timeline",
        model=shape(),
        train={"window": WINDOW},
        normaliser=normaliser,
        fps=Fraction(25),
        origins={},
        origin={},
    )
    return checkpoints.load(folder)


@pytest.fixture(scope="session")
def obedient() -> TimelineModel:
    """A model that learnt for a few seconds that each action moves its channels, both sides.

    Motion is in z-scores: an action lifts its channels from about -1 to about 1.
    """
    rng = np.random.default_rng(0)
    moves = {"BrowUp": (0, 1, 2), "Smile": (3, 4), "EyeClose": (5, 6)}
    clips = []
    for number in range(24):
        timeline = np.zeros((60, len(ACTIONS)), np.float32)
        motion = -np.ones((60, 7), np.float32)
        for action, columns in moves.items():
            first, length = rng.integers(0, 40), rng.integers(12, 30)
            timeline[first : first + length, list(ACTIONS).index(action)] = 1
            motion[first : first + length, columns] += 2
        motion += rng.normal(0, 0.1, motion.shape).astype(np.float32)
        seen = np.ones(60, bool)
        clips.append(Clip(f"{number}", motion, timeline, seen, np.ones(motion.shape, bool)))
    channels = (
        *("browInnerUp", "browOuterUpLeft", "browOuterUpRight"),
        *("mouthSmileLeft", "mouthSmileRight", "eyeBlinkLeft", "eyeBlinkRight"),
    )
    learning = {"steps": 150, "batch": 8, "learning_rate": 1e-2, "ema": 0.9}
    options = Options(**SMALL | learning).model_dump()
    run = train_timeline(TimelineModel(channels, **shape()), clips, [], options)
    return run.average.eval().requires_grad_(False)
