"""Between clean data, noise and noisy data: one small function per equation."""

from torch import Tensor


def add_noise(clean: Tensor, eps: Tensor, signal: Tensor, noise: Tensor) -> Tensor:
    """x_t = signal x_0 + noise eps (Ho et al. 2020, equation 4)."""
    return signal * clean + noise * eps
