import numpy as np
import pytest
import torch

from mimeline.models.jitter import Jitter

SIZES = torch.tensor([0.1, 0.3, 0.2])
PARTS = {"one": [0, 2], "other": [1]}


def clip(length: int, seed: int, jitter=SIZES) -> tuple[torch.Tensor, torch.Tensor]:
    """Slow waves under jitter, the first and last channel's the same but for their sizes."""
    generator = torch.Generator().manual_seed(seed)
    white = torch.randn(length, 3, generator=generator)
    white[:, 2] = white[:, 0]
    frame = torch.arange(length)[:, None]
    smooth = (2 * torch.pi * frame / torch.tensor([80.0, 120, 200])).sin()
    return smooth + jitter * white, torch.ones(length, 3, dtype=torch.bool)


def measured(*clips) -> Jitter:
    jitter = Jitter(3, PARTS)
    jitter.measure(clips)
    return jitter


def covariance(jitter: Jitter) -> torch.Tensor:
    return jitter.basis @ jitter.variance.diag() @ jitter.basis.T


def test_jitter_is_told_from_slow_movement():
    found = covariance(measured(*(clip(400, seed) for seed in range(20))))
    expected = SIZES.outer(SIZES) * torch.tensor([[1.0, 0, 1], [0, 1, 0], [1, 0, 1]])
    assert torch.allclose(found, expected, atol=0.004)


def test_channels_of_two_parts_are_never_correlated():
    motion, known = clip(400, 0)
    motion[:, 1] = motion[:, 0]
    found = covariance(measured((motion, known)))
    assert (found[[0, 2], 1].abs() < 1e-7).all()
    assert found[0, 2] > 0.01


def test_values_that_were_not_measured_do_not_count():
    motion, known = clip(400, 0)
    whole = covariance(measured((motion, known)))
    motion, known = motion.clone(), known.clone()
    motion[100:120, 0], known[100:120, 0] = 50.0, False
    gap = covariance(measured((motion, known)))
    assert torch.allclose(whole, gap, atol=0.003)


def test_quick_movement_of_both_sides_does_not_tie_them_together():
    """Eyelids close in a frame, both at once: that is no reason why one should not wink."""
    motion, known = clip(600, 0, jitter=torch.tensor([0.1, 0.1, 0.1]))
    motion[:, 2] += torch.randn(600, generator=torch.Generator().manual_seed(3)) - motion[:, 0]
    motion[:, 2] *= 0.1
    motion[::40, [0, 2]] += 2
    found = covariance(measured((motion, known)))
    assert found[0, 0] < 0.02
    assert found[0, 2].abs() < 0.002


@pytest.mark.parametrize("length", [0, 1, 2])
def test_where_nothing_can_be_measured_there_is_no_jitter(length):
    jitter = measured(clip(length, 0))
    assert (jitter.variance == 0).all()
    noisy, smooth = torch.randn(2, 2, 5, 3, generator=torch.Generator().manual_seed(0))
    level = torch.tensor(0.6).sqrt().view(1, 1, 1), torch.tensor(0.4).sqrt().view(1, 1, 1)
    assert torch.allclose(jitter(noisy, smooth, *level), smooth)


@pytest.mark.parametrize("noise", [0.05, 0.6, 0.99])
def test_the_filter_is_the_regression_of_clean_on_noisy_motion(noise):
    """No linear estimate of jitter from noisy frames is better: least squares finds the same."""
    jitter = measured(*(clip(400, seed) for seed in range(20)))
    generator = torch.Generator().manual_seed(1)
    white = torch.randn(1, 200_000, 3, generator=generator)
    white[..., 2] = white[..., 0]
    clean = SIZES * white
    signal = (1 - noise**2) ** 0.5
    noisy = signal * clean + noise * torch.randn(clean.shape, generator=generator)
    best, *_ = np.linalg.lstsq(noisy[0].numpy(), clean[0].numpy(), rcond=None)
    factors = torch.tensor(signal).view(1, 1, 1), torch.tensor(noise).view(1, 1, 1)
    found = jitter(noisy, torch.zeros_like(noisy), *factors)
    assert found[0].numpy() == pytest.approx(noisy[0].numpy() @ best, abs=0.03)


def test_hardly_noisy_motion_is_taken_as_it_is_and_noise_is_not():
    jitter = measured(*(clip(400, seed) for seed in range(5)))
    noisy, smooth = torch.randn(2, 1, 50, 3, generator=torch.Generator().manual_seed(0))
    little = torch.tensor(1 - 1e-10).view(1, 1, 1), torch.tensor(1e-5).view(1, 1, 1)
    much = torch.tensor(1e-5).view(1, 1, 1), torch.tensor(1 - 1e-10).view(1, 1, 1)
    taken = jitter(noisy, smooth, *little)
    assert torch.allclose(taken[..., 1], noisy[..., 1], atol=1e-3)
    assert torch.allclose(jitter(noisy, smooth, *much), smooth, atol=1e-4)
