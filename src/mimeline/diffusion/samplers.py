"""From noise to data, given a function that predicts the clean data."""

import math
from collections.abc import Callable

import torch
from torch import Tensor

from mimeline.diffusion.schedule import Schedule

Denoiser = Callable[[Tensor, Tensor], Tensor]  # noisy (B, ...), step (B,) → clean (B, ...)


def even_log_snr(schedule: Schedule, calls: int) -> Tensor:
    """The steps nearest to `calls` evenly spaced log-SNRs, noisiest first; duplicates fall away."""
    levels = schedule.log_snr  # (T,)
    wanted = torch.linspace(levels[-1].item(), levels[0].item(), calls, dtype=levels.dtype)
    nearest = (wanted[:, None] - levels[None, :]).abs().argmin(dim=1)  # (calls,)
    return nearest.unique().flip(0)


def dpmpp_2m(denoise: Denoiser, noise: Tensor, schedule: Schedule, calls: int) -> Tensor:
    """DPM-Solver++(2M), a multistep solver of second order (Lu et al. 2022, algorithm 2).

    denoise predicts the clean data. noise (B, ...) is the standard normal start. The last step
    returns the prediction itself, since at the schedule's least noise it is the answer. Even
    spacing in log-SNR keeps the velocity of motion that even spacing in steps smooths away.

    Returns (B, ...).
    """
    steps = even_log_snr(schedule, calls)
    levels = schedule.log_snr[steps].tolist()
    signal, sigma = schedule.signal[steps].tolist(), schedule.noise[steps].tolist()
    x, before, width_before = noise, None, 0.0
    for i, step in enumerate(steps):
        clean = denoise(x, step.expand(len(x)))
        if i + 1 == len(steps):
            break
        width = levels[i + 1] - levels[i]
        slope = clean
        # First order at the start and before the end, where a second difference adds only error.
        if before is not None and i + 2 < len(steps):
            slope = clean + (clean - before) * (width / (2 * width_before))
        x = sigma[i + 1] / sigma[i] * x - signal[i + 1] * math.expm1(-width) * slope
        before, width_before = clean, width
    return clean
