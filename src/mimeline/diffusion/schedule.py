"""Noise schedules: how much signal and noise a diffusion step holds, as float64 tables."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import torch
from torch import Tensor

LOG_SNR_LIMIT = 5.0  # |log(signal/noise)| of the cosine's ends: unlimited, one step spans all noise
BETAS = (1e-4, 0.02)  # of a linear schedule of 1000 steps (Ho et al. 2020, section 4)


@dataclass(frozen=True)
class Schedule:
    """x_t = signal_t x_0 + noise_t eps, with signal² = alpha_bar and noise² = 1 − alpha_bar.

    alpha_bar: (T,) float64, falling; step 0 is the least noisy. Ho et al. 2020, equation 4.
    """

    alpha_bar: Tensor

    def __len__(self) -> int:
        return len(self.alpha_bar)

    @property
    def signal(self) -> Tensor:
        """(T,) factor of the clean data."""
        return self.alpha_bar.sqrt()

    @property
    def noise(self) -> Tensor:
        """(T,) factor of the noise."""
        return (1 - self.alpha_bar).sqrt()

    @property
    def log_snr(self) -> Tensor:
        """(T,) lambda_t = log(signal_t / noise_t), falling (Lu et al. 2022, section 2)."""
        return self.signal.log() - self.noise.log()

    def at(self, step: Tensor, like: Tensor) -> tuple[Tensor, Tensor]:
        """Signal and noise of each step (B,), shaped and typed to multiply like (B, ...)."""
        shape = (-1,) + (1,) * (like.dim() - 1)
        step = step.to(self.alpha_bar.device)
        return (
            self.signal[step].to(like).view(shape),  # (B, 1, ...)
            self.noise[step].to(like).view(shape),  # (B, 1, ...)
        )


def cosine(steps: int) -> Schedule:
    """signal = cos(angle), the angle rises evenly (Nichol & Dhariwal 2021, equation 17).

    The ends are set so that |log-SNR| stays within LOG_SNR_LIMIT.
    """
    ends = [math.atan(math.exp(-limit)) for limit in (LOG_SNR_LIMIT, -LOG_SNR_LIMIT)]
    angle = torch.linspace(*ends, steps, dtype=torch.float64)
    return Schedule(angle.cos() ** 2)


def linear(steps: int) -> Schedule:
    """beta rises evenly (Ho et al. 2020, section 4); of fewer steps each adds more noise."""
    low, high = (beta * 1000 / steps for beta in BETAS)
    beta = torch.linspace(low, high, steps, dtype=torch.float64)
    return Schedule((1 - beta.clamp(max=0.999)).cumprod(dim=0))


SCHEDULES: dict[str, Callable[[int], Schedule]] = {"cosine": cosine, "linear": linear}
