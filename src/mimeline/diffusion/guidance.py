"""Classifier-free guidance: away from what is likely anyway, toward what the condition asks for."""

from collections.abc import Callable

import torch
from torch import Tensor

from mimeline.diffusion.samplers import Denoiser


def classifier_free(
    predict: Callable[[Tensor, Tensor, Tensor, Tensor], Tensor],
    condition: Tensor,
    null: Tensor,
    valid: Tensor,
    scale: float,
) -> Denoiser:
    """The denoiser null + scale · (conditional − null) (Ho & Salimans 2022, equation 6, at x_0).

    predict: noisy (B, L, D), step (B,), condition (B, L, C), valid (B, L) → clean (B, L, D).
    condition, null (B, L, C); scale 1 is the condition alone, 0 the null alone: one pass each.
    Other scales run both passes in one batch.
    """
    if scale in (0, 1):
        alone = condition if scale == 1 else null
        return lambda noisy, step: predict(noisy, step, alone, valid)
    both = torch.cat([condition, null])  # (2B, L, C)
    both_valid = valid.repeat(2, 1)  # (2B, L)

    def denoise(noisy: Tensor, step: Tensor) -> Tensor:
        clean = predict(noisy.repeat(2, 1, 1), step.repeat(2), both, both_valid)  # (2B, L, D)
        given, absent = clean.chunk(2)  # (B, L, D) each
        return absent + scale * (given - absent)

    return denoise
