import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from mimeline.diffusion.conversions import (
    add_noise,
    clean_from_eps,
    clean_from_velocity,
    eps_from_clean,
    posterior,
    velocity,
)
from mimeline.diffusion.schedule import SCHEDULES

levels = st.floats(0.001, 0.999)


@given(levels, st.integers(0, 2**31))
def test_clean_noise_and_velocity_tell_the_same(alpha_bar, seed):
    generator = torch.Generator().manual_seed(seed)
    clean, eps = torch.randn(2, 3, 4, generator=generator, dtype=torch.float64)
    factors = alpha_bar**0.5, (1 - alpha_bar) ** 0.5
    noisy = add_noise(clean, eps, *factors)
    v = velocity(clean, eps, *factors)
    for found, true in (
        (clean_from_eps(noisy, eps, *factors), clean),
        (eps_from_clean(noisy, clean, *factors), eps),
        (clean_from_velocity(noisy, v, *factors), clean),
    ):
        assert torch.allclose(found, true, rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", sorted(SCHEDULES))
@pytest.mark.parametrize("step", [1, 40, 99])
def test_the_posterior_of_one_step_is_the_textbooks(name, step):
    alpha_bar = SCHEDULES[name](100).alpha_bar
    now, before = alpha_bar[step].item(), alpha_bar[step - 1].item()
    beta = 1 - now / before
    noisy, clean = torch.tensor([[1.5, -0.3], [0.2, 0.7]]).double()
    mean, std = posterior(noisy, clean, now, before)
    of_clean, of_noisy = before**0.5 * beta, (1 - beta) ** 0.5 * (1 - before)
    assert torch.allclose(mean, (of_clean * clean + of_noisy * noisy) / (1 - now))
    assert std**2 == pytest.approx((1 - before) / (1 - now) * beta)


@given(st.tuples(levels, levels).filter(lambda pair: pair[0] < pair[1]))
def test_a_posterior_step_leads_to_the_noise_of_its_level(pair):
    """x_s = sqrt(s) x_0 + sqrt(1 − s) eps, however far t is from s."""
    now, before = pair
    one, none = torch.tensor(1.0).double(), torch.tensor(0.0).double()
    of_clean, std = posterior(none, one, now, before)
    of_noisy, _ = posterior(one, none, now, before)
    assert of_clean + of_noisy * now**0.5 == pytest.approx(before**0.5)
    assert of_noisy**2 * (1 - now) + std**2 == pytest.approx(1 - before)
