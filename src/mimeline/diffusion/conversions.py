"""Between clean data, noise, velocity and noisy data: one small function per equation.

signal, noise: the factors of `Schedule` at a step, numbers or tensors that multiply like the data;
x_t = signal x_0 + noise eps, signal² + noise² = 1.
"""

from torch import Tensor

Factor = Tensor | float


def add_noise(clean: Tensor, eps: Tensor, signal: Factor, noise: Factor) -> Tensor:
    """x_t = signal x_0 + noise eps (Ho et al. 2020, equation 4)."""
    return signal * clean + noise * eps


def clean_from_eps(noisy: Tensor, eps: Tensor, signal: Factor, noise: Factor) -> Tensor:
    """x_0 = (x_t − noise eps) / signal (Ho et al. 2020, equation 15)."""
    return (noisy - noise * eps) / signal


def eps_from_clean(noisy: Tensor, clean: Tensor, signal: Factor, noise: Factor) -> Tensor:
    """eps = (x_t − signal x_0) / noise (Ho et al. 2020, equation 4, solved for eps)."""
    return (noisy - signal * clean) / noise


def velocity(clean: Tensor, eps: Tensor, signal: Factor, noise: Factor) -> Tensor:
    """v = signal eps − noise x_0 (Salimans & Ho 2022, section 4)."""
    return signal * eps - noise * clean


def clean_from_velocity(noisy: Tensor, v: Tensor, signal: Factor, noise: Factor) -> Tensor:
    """x_0 = signal x_t − noise v (Salimans & Ho 2022, appendix D)."""
    return signal * noisy - noise * v


def posterior(
    noisy: Tensor, clean: Tensor, alpha_bar: float, alpha_bar_before: float
) -> tuple[Tensor, float]:
    """Mean and standard deviation of x_s given x_t and x_0, s < t (Ho et al. 2020, eqs. 6 and 7).

    alpha_bar: at t; alpha_bar_before: at s, of any smaller step, not only the one before.
    """
    alpha = alpha_bar / alpha_bar_before  # what is left of the signal from s to t
    rest = 1 - alpha_bar
    of_clean = alpha_bar_before**0.5 * (1 - alpha) / rest
    of_noisy = alpha**0.5 * (1 - alpha_bar_before) / rest
    variance = (1 - alpha_bar_before) / rest * (1 - alpha)
    return of_clean * clean + of_noisy * noisy, variance**0.5
