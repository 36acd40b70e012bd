import pytest
import torch

from mimeline.diffusion.samplers import SAMPLERS, even_log_snr, sample
from mimeline.diffusion.schedule import SCHEDULES, cosine

NAMES = sorted(SAMPLERS)
MEAN = torch.tensor([2.0, -1.0, 0.0])
STD = torch.tensor([0.1, 1.0, 3.0])


def gaussian_denoiser(schedule):
    """The exact posterior mean of independent Gaussians."""

    def denoise(noisy, step):
        signal, noise = schedule.at(step, noisy)
        gain = signal * STD**2 / (signal**2 * STD**2 + noise**2)
        return MEAN + gain * (noisy - signal * MEAN)

    return denoise


def never():
    raise AssertionError("this sampler takes no noise")


@pytest.mark.parametrize(
    ("sampler", "calls"), [("ddpm", 1000), ("ddim", 100), ("dpmpp_2m", 20), ("dpmpp_2m", 40)]
)
def test_the_exact_denoiser_gives_the_moments_of_a_gaussian(sampler, calls):
    schedule, generator = cosine(1000), torch.Generator().manual_seed(0)

    def draw():
        return torch.randn(8_000, 3, generator=generator)

    drawn = sample(sampler, gaussian_denoiser(schedule), draw(), schedule, calls, draw)
    assert torch.allclose(drawn.mean(dim=0), MEAN, atol=0.1)
    assert torch.allclose(drawn.std(dim=0) / STD, torch.ones(3), atol=0.04)


@pytest.mark.parametrize("sampler", NAMES)
@pytest.mark.parametrize("schedule", sorted(SCHEDULES))
def test_a_sample_is_the_last_prediction(sampler, schedule):
    asked = []

    def denoise(noisy, step):
        assert step.shape == (2,)
        asked.append(step[0].item())
        return torch.full_like(noisy, float(len(asked)))

    noise = torch.ones(2, 3)
    schedule = SCHEDULES[schedule](100)
    drawn = sample(sampler, denoise, noise, schedule, 6, lambda: noise)
    assert asked == even_log_snr(schedule, 6).tolist()
    assert (asked[0], asked[-1], len(asked)) == (99, 0, 6)
    assert (drawn == 6).all()


@pytest.mark.parametrize("sampler", NAMES)
def test_one_call_answers_with_its_prediction(sampler):
    drawn = sample(sampler, lambda x, _: x + 1, torch.zeros(1, 2), cosine(1), 1, never)
    assert (drawn == 1).all()


@pytest.mark.parametrize("sampler", ["ddim", "dpmpp_2m"])
def test_a_deterministic_sampler_draws_no_noise(sampler):
    schedule = cosine(50)
    sample(sampler, gaussian_denoiser(schedule), torch.ones(2, 3), schedule, 5, never)


def test_the_ancestral_sampler_draws_at_each_step_but_the_last():
    schedule, drawn = cosine(50), []

    def draw():
        drawn.append(torch.zeros(2, 3))
        return drawn[-1]

    sample("ddpm", gaussian_denoiser(schedule), torch.ones(2, 3), schedule, 7, draw)
    assert len(drawn) == 6


def test_steps_are_spaced_evenly_in_log_snr():
    schedule = cosine(1000)
    gaps = schedule.log_snr[even_log_snr(schedule, 11)].diff()
    assert torch.allclose(gaps, torch.ones(10).double(), atol=0.15)


@pytest.mark.parametrize("calls", [5, 20])
def test_a_short_schedule_gives_each_step_once(calls):
    assert even_log_snr(cosine(5), calls).tolist() == [4, 3, 2, 1, 0]


def test_diffusers_takes_the_same_way_with_ddim():
    """On every step of a short schedule, where both visit the same ones."""
    diffusers = pytest.importorskip("diffusers")
    schedule = cosine(20)
    alpha_bar = schedule.alpha_bar
    before = torch.cat([torch.ones(1).double(), alpha_bar[:-1]])
    theirs = diffusers.DDIMScheduler(
        num_train_timesteps=20,
        prediction_type="sample",
        trained_betas=(1 - alpha_bar / before).numpy(),
        clip_sample=False,
        set_alpha_to_one=True,
    )
    theirs.set_timesteps(20)
    denoise = gaussian_denoiser(schedule)
    x = noise = torch.randn(4, 3, generator=torch.Generator().manual_seed(0))
    for step in theirs.timesteps:
        x = theirs.step(denoise(x, step.expand(len(x))), step, x).prev_sample
    assert (sample("ddim", denoise, noise, schedule, 20, never) - x).abs().max() < 1e-4


@pytest.mark.parametrize("name", sorted(SCHEDULES))
def test_diffusers_takes_the_same_way_with_dpmpp_2m(name):
    diffusers = pytest.importorskip("diffusers")
    schedule = SCHEDULES[name](1000)
    alpha_bar = schedule.alpha_bar
    before = torch.cat([torch.ones(1).double(), alpha_bar[:-1]])
    theirs = diffusers.DPMSolverMultistepScheduler(
        num_train_timesteps=1000,
        prediction_type="sample",
        trained_betas=(1 - alpha_bar / before).numpy(),
        solver_order=2,
        lower_order_final=False,
        final_sigmas_type="zero",
    )
    theirs.set_timesteps(timesteps=even_log_snr(schedule, 20).tolist())
    denoise = gaussian_denoiser(schedule)
    x = noise = torch.randn(4, 3, generator=torch.Generator().manual_seed(0)).double()
    for step in theirs.timesteps:
        x = theirs.step(denoise(x, step.long().expand(len(x))), step, x).prev_sample
    assert (sample("dpmpp_2m", denoise, noise, schedule, 20, never) - x).abs().max() < 1e-5
