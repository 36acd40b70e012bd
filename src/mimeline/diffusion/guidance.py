"""Classifier-free guidance: away from what is likely anyway, toward what the conditions ask for."""

from collections.abc import Callable, Sequence

import torch
from torch import Tensor

from mimeline.diffusion.samplers import Denoiser

Condition = tuple[Tensor, ...]  # what a model is told, each batch first
Listen = Callable[..., Denoiser]  # the tensors of a Condition → the denoiser that is told them


def guided(
    listen: Listen,
    conditions: Sequence[Condition],
    null: Condition,
    scales: Sequence[float],
    interval: tuple[int, int] | None = None,
) -> Denoiser:
    """The denoiser null + Σ scale_i (condition_i − null), all of it predictions of x_0.

    Of one condition Ho & Salimans 2022, equation 6; of several Liu et al. 2022, equation 11. All
    predictions that count are made in one batch; with one condition and scale 1 that is one.
    interval: the first and the last diffusion step of guidance; at other steps every scale is 1
    (Kynkäänniemi et al. 2024, equation 6).
    """
    everything = [*conditions, null]

    def combined(scales: Sequence[float]) -> Denoiser:
        return weighted(listen, everything, [*scales, 1 - sum(scales)])

    strong = combined(scales)
    if interval is None:
        return strong
    plain = combined([1.0] * len(conditions))
    first, last = interval

    def denoise(noisy: Tensor, step: Tensor) -> Tensor:
        return (strong if first <= step[0] <= last else plain)(noisy, step)

    return denoise


def weighted(
    listen: Listen, conditions: Sequence[Condition], weights: Sequence[float | Tensor]
) -> Denoiser:
    """The denoiser Σ weight_i condition_i, in one batch; a weight of 0 costs nothing.

    A weight may be a tensor that multiplies like the data (B, ...).
    """
    used = [
        (condition, weight)
        for condition, weight in zip(conditions, weights, strict=True)
        if isinstance(weight, Tensor) or weight != 0
    ]
    told = listen(*(torch.cat(parts) for parts in zip(*(c for c, _ in used), strict=True)))

    def denoise(noisy: Tensor, step: Tensor) -> Tensor:
        clean = told(torch.cat([noisy] * len(used)), step.repeat(len(used)))
        each = clean.chunk(len(used))  # (B, ...) each
        return sum(weight * own for (_, weight), own in zip(used, each, strict=True))

    return denoise
