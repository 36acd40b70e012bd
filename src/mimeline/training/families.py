"""The families of models, by the name that config and checkpoints give them."""

from collections.abc import Callable
from dataclasses import dataclass

from torch import nn

from mimeline.models.timeline import TimelineModel
from mimeline.training.loop import Run
from mimeline.training.timeline import train_timeline


@dataclass(frozen=True)
class Family:
    """What a family needs to be trained and read again.

    model: its class, whose constructor takes channels and the config keys in architecture.
    train(model, training clips, validation clips, options, hardware, state, tensorboard) trains
    it; it is found by its name in other processes.
    """

    model: type[nn.Module]
    architecture: tuple[str, ...]
    train: Callable[..., Run]


FAMILIES: dict[str, Family] = {
    "timeline": Family(
        TimelineModel,
        (
            "width",
            "heads",
            "base_layers",
            "branch_layers",
            "branches",
            "timeline_tokens",
            "schedule",
            "diffusion_steps",
        ),
        train_timeline,
    ),
}
