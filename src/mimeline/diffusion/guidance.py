"""Classifier-free guidance: away from what is likely anyway, toward what the conditions ask for."""

from collections.abc import Callable, Sequence

import torch
from torch import Tensor

from mimeline.diffusion.samplers import Denoiser

Condition = tuple[Tensor, ...]  # what a model is told, each batch first
Listen = Callable[..., Denoiser]  # the tensors of a Condition → the denoiser that is told them


def guided(
    listen: Listen, conditions: Sequence[Condition], null: Condition, scales: Sequence[float]
) -> Denoiser:
    """The denoiser null + Σ scale_i (condition_i − null), all of it predictions of x_0.

    Of one condition Ho & Salimans 2022, equation 6; of several Liu et al. 2022, equation 11. All
    predictions that count are made in one batch: with one condition and scale 1 that is one.
    """
    weights = [*scales, 1 - sum(scales)]
    used = [
        (told, weight)
        for told, weight in zip([*conditions, null], weights, strict=True)
        if weight != 0
    ]
    heard = listen(*(torch.cat(parts) for parts in zip(*(told for told, _ in used), strict=True)))

    def denoise(noisy: Tensor, step: Tensor) -> Tensor:
        clean = heard(torch.cat([noisy] * len(used)), step.repeat(len(used)))
        each = clean.chunk(len(used))  # (B, ...) each
        return sum(weight * own for (_, weight), own in zip(used, each, strict=True))

    return denoise


def between(first: int, last: int, inside: Denoiser, outside: Denoiser) -> Denoiser:
    """One denoiser from the first to the last of some steps, another at all other steps.

    Guidance does good in the middle of the schedule alone (Kynkäänniemi et al. 2024, equation 6).
    All samples of a batch are at one step.
    """

    def denoise(noisy: Tensor, step: Tensor) -> Tensor:
        return (inside if first <= step[0] <= last else outside)(noisy, step)

    return denoise
