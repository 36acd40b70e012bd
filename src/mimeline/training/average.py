"""An exponential moving average of a model's weights."""

import copy

import torch
from torch import nn


class Average:
    """A copy of the model whose weights follow the model's slowly.

    decay: how much of the average stays at each step; early on less, so that the random start is
    forgotten: at update n at most (1 + n) / (10 + n).
    """

    def __init__(self, model: nn.Module, decay: float):
        self.model = copy.deepcopy(model).requires_grad_(False).eval()
        self.decay = decay
        self.updates = 0

    @torch.no_grad()
    def update(self, model: nn.Module) -> None:
        """Move the average toward the model."""
        self.updates += 1
        decay = min(self.decay, (1 + self.updates) / (10 + self.updates))
        for mean, now in zip(self.model.parameters(), model.parameters(), strict=True):
            mean.lerp_(now, 1 - decay)
