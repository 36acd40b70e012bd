import pytest
import torch

from mimeline.diffusion.guidance import between, guided

NULL, FIRST, SECOND = 1.0, 3.0, -2.0
STEP = torch.tensor([5, 5])


def told(value: float) -> tuple[torch.Tensor, torch.Tensor]:
    return torch.full((2, 4, 1), value), torch.ones(2, 4, dtype=torch.bool)


class Listener:
    """A model that says what it was told, and keeps the sizes of its batches."""

    def __init__(self):
        self.told, self.asked = [], []

    def __call__(self, value, valid):
        assert len(value) == len(valid)
        self.told.append(len(value))

        def denoise(noisy, step):
            assert len(noisy) == len(step) == len(value)
            self.asked.append(len(noisy))
            return noisy + value

        return denoise


@pytest.mark.parametrize(("scale", "batch"), [(0.0, 2), (1.0, 2), (2.5, 4)])
def test_guidance_goes_from_the_null_past_the_condition_in_no_needless_pass(scale, batch):
    listener = Listener()
    denoise = guided(listener, [told(FIRST)], told(NULL), [scale])
    for _ in range(3):
        clean = denoise(torch.zeros(2, 4, 1), STEP)
    assert torch.allclose(clean, torch.full((2, 4, 1), NULL + scale * (FIRST - NULL)))
    assert listener.asked == [batch] * 3
    assert listener.told == [batch]


def test_each_condition_has_a_scale_of_its_own():
    denoise = guided(Listener(), [told(FIRST), told(SECOND)], told(NULL), [2.0, 0.5])
    wanted = NULL + 2 * (FIRST - NULL) + 0.5 * (SECOND - NULL)
    assert torch.allclose(denoise(torch.zeros(2, 4, 1), STEP), torch.full((2, 4, 1), wanted))


@pytest.mark.parametrize(("step", "said"), [(3, FIRST), (4, SECOND), (6, SECOND), (7, FIRST)])
def test_a_denoiser_is_on_between_two_steps_alone(step, said):
    inside, outside = Listener()(*told(SECOND)), Listener()(*told(FIRST))
    clean = between(4, 6, inside, outside)(torch.zeros(2, 4, 1), torch.tensor([step, step]))
    assert torch.allclose(clean, torch.full((2, 4, 1), said))
