import pytest
import torch

from mimeline.generation.sides import left_share, two_sided
from mimeline.vocabulary import CHANNELS

NAMES = ("browOuterUpLeft", "browOuterUpRight", "browInnerUp", "jawLeft", "gaze_left")


def echo(told: torch.Tensor, valid: torch.Tensor):
    """A model that puts what it is told first into every channel."""
    return lambda noisy, step: told[..., :1] + 0 * noisy + step[:, None, None]


def counting(sizes: list[int]):
    def listen(told, valid):
        sizes.append(len(told))
        return echo(told, valid)

    return listen


def asked(*first: float) -> torch.Tensor:
    """Timelines (B, 4, 16) whose first action is as given, one per sequence."""
    return torch.tensor(first)[:, None, None].expand(-1, 4, 16)


VALID, NOISY, STEP = torch.ones(3, 4, dtype=torch.bool), torch.zeros(3, 4, 5), torch.zeros(3)


def test_a_channel_follows_its_half_and_one_without_a_side_the_mean_of_both():
    made = two_sided(echo, NAMES)(asked(1, 1, 0), asked(0, 1, 1), VALID)(NOISY, STEP)
    assert made[0, 0].tolist() == [1, 0, 0.5, 0.5, 0.5]
    assert made[1, 0].tolist() == [1, 1, 1, 1, 1]
    assert made[2, 0].tolist() == [0, 1, 0.5, 0.5, 0.5]


def test_only_sequences_whose_halves_differ_are_predicted_twice():
    sizes = []
    listen = two_sided(counting(sizes), NAMES)
    listen(asked(1, 1, 0), asked(1, 1, 0), VALID)
    listen(asked(1, 1, 0), asked(1, 0, 0), VALID)
    assert sizes == [3, 4]


def test_each_sequence_is_told_its_own_diffusion_step():
    step = torch.tensor([1, 2, 3])
    made = two_sided(echo, NAMES)(asked(0, 0, 0), asked(0, 1, 1), VALID)(NOISY, step)
    assert made[:, 0, 1].tolist() == [1, 3, 4]


def test_every_channel_and_its_mirror_image_share_the_face():
    for name, channel in CHANNELS.items():
        assert left_share(name) + left_share(channel.mirror) == 1
        whole = name == channel.mirror or name in WAYS or name.startswith("eyeLook")
        assert (left_share(name) == 0.5) == whole, name


WAYS = ("jawLeft", "jawRight", "mouthLeft", "mouthRight")


@pytest.mark.parametrize("name", ["eyeBlinkLeft", "cheekSquintLeft", "browDownLeft"])
def test_channels_of_the_left_half_are_left(name):
    assert left_share(name) == 1
