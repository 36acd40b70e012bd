"""What one step of training teaches."""

from dataclasses import dataclass

import torch
from torch import Tensor, nn


@dataclass(frozen=True)
class Lesson:
    """Clips, what the model is shown of them, and what it should make of that.

    clip_ids: B names. shown: the model's arguments, batch-first tensors. target (B, L, D): what it
    should return. weight (B, L, D): of each value in the loss; all weights together are 1, so that
    the losses of a lesson's parts add up to its own.
    """

    clip_ids: tuple[str, ...]
    shown: tuple[Tensor, ...]
    target: Tensor
    weight: Tensor

    def part(self, number: int, of: int, device: torch.device) -> "Lesson":
        """Every `of`-th clip from `number` on, on the device."""
        own = slice(number, None, of)
        shown = tuple(tensor[own].to(device) for tensor in self.shown)
        target, weight = self.target[own].to(device), self.weight[own].to(device)
        return Lesson(self.clip_ids[own], shown, target, weight)


def square_error(model: nn.Module, lesson: Lesson) -> Tensor:
    """Mean square error, weighted as the lesson says."""
    return (lesson.weight * (model(*lesson.shown) - lesson.target).square()).sum()
