import pytest
import torch

from mimeline.diffusion.guidance import classifier_free
from mimeline.diffusion.samplers import dpmpp_2m, even_log_snr
from mimeline.diffusion.schedule import cosine

MEAN = torch.tensor([2.0, -1.0, 0.0])
STD = torch.tensor([0.1, 1.0, 3.0])


def gaussian_denoiser(schedule):
    """The exact posterior mean of independent Gaussians."""

    def denoise(noisy, step):
        signal, noise = schedule.at(step, noisy)
        gain = signal * STD**2 / (signal**2 * STD**2 + noise**2)
        return MEAN + gain * (noisy - signal * MEAN)

    return denoise


def test_twenty_calls_give_the_moments_of_a_gaussian():
    schedule = cosine(1000)
    noise = torch.randn(20_000, 3, generator=torch.Generator().manual_seed(0))
    drawn = dpmpp_2m(gaussian_denoiser(schedule), noise, schedule, calls=20)
    assert torch.allclose(drawn.mean(dim=0), MEAN, atol=0.06)
    assert torch.allclose(drawn.std(dim=0) / STD, torch.ones(3), atol=0.03)


def test_a_sample_is_the_last_prediction():
    schedule, seen = cosine(100), []

    def denoise(noisy, step):
        seen.append((step[0].item(), torch.full_like(noisy, float(len(seen)))))
        return seen[-1][1]

    drawn = dpmpp_2m(denoise, torch.zeros(2, 3), schedule, calls=6)
    assert len(seen) == 6
    assert [step for step, _ in seen] == sorted((step for step, _ in seen), reverse=True)
    assert (seen[0][0], seen[-1][0]) == (99, 0)
    assert (drawn == 5).all()


def test_steps_are_spaced_evenly_in_log_snr():
    schedule = cosine(1000)
    gaps = schedule.log_snr[even_log_snr(schedule, 11)].diff()
    assert torch.allclose(gaps, torch.ones(10).double(), atol=0.15)


def test_a_short_schedule_gives_each_step_once():
    assert even_log_snr(cosine(5), 20).tolist() == [4, 3, 2, 1, 0]


@pytest.mark.parametrize("scale", [0.0, 1.0, 2.5])
def test_guidance_goes_from_the_null_past_the_condition(scale):
    condition, null = torch.full((2, 4, 1), 3.0), torch.full((2, 4, 1), 1.0)
    valid = torch.ones(2, 4, dtype=torch.bool)
    calls = []

    def predict(noisy, step, given, mask):
        calls.append(len(noisy))
        assert len(noisy) == len(step) == len(given) == len(mask)
        return noisy + given

    denoise = classifier_free(predict, condition, null, valid, scale)
    clean = denoise(torch.zeros(2, 4, 1), torch.zeros(2, dtype=torch.long))
    assert torch.allclose(clean, torch.full((2, 4, 1), 1 + scale * 2))
    assert calls == [4 if scale == 2.5 else 2]
