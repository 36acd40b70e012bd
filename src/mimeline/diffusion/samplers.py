"""From noise to data, given a function that predicts the clean data."""

import math
from collections.abc import Callable
from itertools import pairwise

import torch
from torch import Tensor

from mimeline.diffusion.conversions import add_noise, eps_from_clean, posterior
from mimeline.diffusion.schedule import Schedule

Denoiser = Callable[[Tensor, Tensor], Tensor]  # noisy (B, ...), step (B,) → clean (B, ...)
Draw = Callable[[], Tensor]  # standard normal noise, (B, ...) like the data
Sampler = Callable[[Denoiser, Tensor, Schedule, Tensor, Draw], Tensor]


def sample(
    sampler: str, denoise: Denoiser, noise: Tensor, schedule: Schedule, calls: int, draw: Draw
) -> Tensor:
    """Data (B, ...) from standard normal noise (B, ...), in so many calls of the denoiser.

    sampler: a name of SAMPLERS. denoise predicts the clean data. draw: fresh noise, for those
    samplers that take some. All end with the prediction at the least noise, which is the answer.
    """
    return SAMPLERS[sampler](denoise, noise, schedule, even_log_snr(schedule, calls), draw)


def even_log_snr(schedule: Schedule, calls: int) -> Tensor:
    """The steps nearest to `calls` evenly spaced log-SNRs, noisiest first; duplicates fall away.

    As many calls as there are steps are the steps themselves. Even spacing in log-SNR keeps the
    velocity of motion that even spacing in steps smooths away.
    """
    if calls >= len(schedule):
        return torch.arange(len(schedule) - 1, -1, -1)
    levels = schedule.log_snr  # (T,)
    wanted = torch.linspace(levels[-1].item(), levels[0].item(), calls, dtype=levels.dtype)
    nearest = (wanted[:, None] - levels[None, :]).abs().argmin(dim=1)  # (calls,)
    return nearest.unique().flip(0)


def ddpm(denoise: Denoiser, noise: Tensor, schedule: Schedule, steps: Tensor, draw: Draw) -> Tensor:
    """Ancestral sampling, with fresh noise at each step (Ho et al. 2020, algorithm 2)."""
    x = noise
    for now, after in pairwise(steps):
        clean = denoise(x, now.expand(len(x)))
        levels = schedule.alpha_bar[now].item(), schedule.alpha_bar[after].item()
        mean, std = posterior(x, clean, *levels)
        x = mean + std * draw()
    return denoise(x, steps[-1].expand(len(x)))


def ddim(denoise: Denoiser, noise: Tensor, schedule: Schedule, steps: Tensor, draw: Draw) -> Tensor:
    """The deterministic sampler of first order (Song et al. 2021, equation 12 with sigma 0)."""
    x, signal, sigma = noise, schedule.signal.tolist(), schedule.noise.tolist()
    for now, after in pairwise(steps):
        clean = denoise(x, now.expand(len(x)))
        eps = eps_from_clean(x, clean, signal[now], sigma[now])
        x = add_noise(clean, eps, signal[after], sigma[after])
    return denoise(x, steps[-1].expand(len(x)))


def dpmpp_2m(
    denoise: Denoiser, noise: Tensor, schedule: Schedule, steps: Tensor, draw: Draw
) -> Tensor:
    """DPM-Solver++(2M), a multistep solver of second order (Lu et al. 2022, algorithm 2)."""
    levels = schedule.log_snr[steps].tolist()
    signal, sigma = schedule.signal[steps].tolist(), schedule.noise[steps].tolist()
    x, before, width_before = noise, None, 0.0
    for i, step in enumerate(steps[:-1]):
        clean = denoise(x, step.expand(len(x)))
        width = levels[i + 1] - levels[i]
        slope = clean  # of first order, where there is no call before
        if before is not None:
            slope = clean + (clean - before) * (width / (2 * width_before))
        x = sigma[i + 1] / sigma[i] * x - signal[i + 1] * math.expm1(-width) * slope
        before, width_before = clean, width
    return denoise(x, steps[-1].expand(len(x)))


SAMPLERS: dict[str, Sampler] = {"ddpm": ddpm, "ddim": ddim, "dpmpp_2m": dpmpp_2m}
