import math

import pytest
import torch

from mimeline.diffusion.schedule import LOG_SNR_LIMIT, SCHEDULES, cosine, linear

NAMES = sorted(SCHEDULES)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("steps", [1, 20, 1000, 2000])
def test_every_step_holds_less_signal_than_the_one_before(name, steps):
    schedule = SCHEDULES[name](steps)
    assert len(schedule) == steps
    assert schedule.alpha_bar.dtype == torch.float64
    assert (schedule.alpha_bar.diff() < 0).all()
    assert (schedule.log_snr.diff() < 0).all()
    assert ((schedule.alpha_bar > 0) & (schedule.alpha_bar < 1)).all()


@pytest.mark.parametrize("name", NAMES)
def test_signal_and_noise_keep_the_variance(name):
    schedule = SCHEDULES[name](1000)
    total = schedule.signal**2 + schedule.noise**2
    assert torch.allclose(total, torch.ones(1000).double(), rtol=0, atol=1e-14)


def test_the_cosine_ends_at_its_limits():
    levels = cosine(100).log_snr
    assert levels[[0, -1]].tolist() == pytest.approx([LOG_SNR_LIMIT, -LOG_SNR_LIMIT])


def test_the_linear_schedule_of_a_thousand_steps_is_that_of_the_literature():
    betas = [1e-4 + (0.02 - 1e-4) * i / 999 for i in range(1000)]
    assert linear(1000).alpha_bar[-1].item() == pytest.approx(math.prod(1 - b for b in betas))
    assert linear(1000).alpha_bar[-1].item() == pytest.approx(4.0358e-5, rel=1e-4)


@pytest.mark.parametrize("steps", [500, 2000])
def test_a_linear_schedule_of_many_steps_ends_as_noisy_as_that_of_a_thousand(steps):
    assert linear(steps).log_snr[-1].item() == pytest.approx(
        linear(1000).log_snr[-1].item(), rel=0.05
    )


@pytest.mark.parametrize("steps", [10, 30, 100])
def test_a_linear_schedule_of_few_steps_ends_with_no_less_noise(steps):
    assert linear(steps).log_snr[-1] < linear(1000).log_snr[-1]


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_the_factors_of_each_step_multiply_like_the_data(dtype):
    schedule, like = cosine(10), torch.zeros(3, 5, 2, dtype=dtype)
    signal, noise = schedule.at(torch.tensor([0, 9, 4]), like)
    assert signal.shape == noise.shape == (3, 1, 1)
    assert signal.dtype == noise.dtype == dtype
    assert torch.equal(signal[:, 0, 0], schedule.signal[[0, 9, 4]].to(dtype))
