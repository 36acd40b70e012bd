"""The families of models, by the name that config and checkpoints give them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from torch import nn

from mimeline.dataset.windows import Clip
from mimeline.models.timeline import TimelineModel
from mimeline.training.loop import Run
from mimeline.training.timeline import train_timeline


@dataclass(frozen=True)
class Family:
    """What a family needs to be trained and read again.

    model: its class, whose constructor takes channels and the config keys in architecture.
    train(model, training clips, validation clips, options) trains it.
    """

    model: type[nn.Module]
    architecture: tuple[str, ...]
    train: Callable[[Any, Sequence[Clip], Sequence[Clip], Mapping[str, Any]], Run]


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
            "diffusion_steps",
        ),
        train_timeline,
    ),
}
