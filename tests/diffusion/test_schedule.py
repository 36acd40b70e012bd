import pytest
import torch

from mimeline.diffusion.conversions import add_noise
from mimeline.diffusion.schedule import LOG_SNR_LIMIT, cosine


@pytest.mark.parametrize("steps", [20, 1000])
def test_every_step_holds_less_signal_than_the_one_before(steps):
    schedule = cosine(steps)
    assert len(schedule) == steps
    assert (schedule.alpha_bar.diff() < 0).all()
    assert 0 < schedule.alpha_bar[-1] < 0.01
    assert 0.99 < schedule.alpha_bar[0] < 1


def test_signal_and_noise_keep_the_variance():
    schedule = cosine(50)
    assert torch.allclose(schedule.signal**2 + schedule.noise**2, torch.ones(50).double())


def test_the_cosine_ends_at_its_limits():
    levels = cosine(100).log_snr
    assert levels[0] == pytest.approx(LOG_SNR_LIMIT)
    assert levels[-1] == pytest.approx(-LOG_SNR_LIMIT)


def test_noise_of_unit_variance_keeps_the_variance_of_the_data():
    generator = torch.Generator().manual_seed(0)
    clean, eps = torch.randn(2, 4, 5000, generator=generator).double()
    noisy = add_noise(clean, eps, *cosine(10).at(torch.tensor([0, 3, 6, 9]), clean))
    assert torch.allclose(noisy.var(dim=1), torch.ones(4).double(), atol=0.1)
