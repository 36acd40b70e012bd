"""The halves of the face asked for different things."""

from collections.abc import Sequence

import torch
from torch import Tensor

from mimeline.diffusion.guidance import Listen
from mimeline.diffusion.samplers import Denoiser

DIRECTIONS = ("jawLeft", "jawRight", "mouthLeft", "mouthRight")  # a way to move, not a half
TOGETHER = "eyeLook"  # both eyes look at one thing


def two_sided(listen: Listen, channels: Sequence[str]) -> Listen:
    """A model that listens to a timeline for each half of the face, (left, right, valid).

    A channel of a half follows that half's timeline, any other the mean of what the model makes of
    both. The halves are denoised as one face, so that they agree on all that is not told apart;
    sequences whose halves are told the same are predicted once.
    """
    share = torch.tensor([left_share(channel) for channel in channels])  # (D,)

    def listen_both(left: Tensor, right: Tensor, valid: Tensor) -> Denoiser:
        apart = (left != right).any(dim=2).any(dim=1).nonzero()[:, 0]  # (S,) of the B sequences
        told = listen(torch.cat([left, right[apart]]), torch.cat([valid, valid[apart]]))

        def denoise(noisy: Tensor, step: Tensor) -> Tensor:
            both = told(torch.cat([noisy, noisy[apart]]), torch.cat([step, step[apart]]))
            clean, of_right = both.split([len(noisy), len(apart)])  # (B, L, D), (S, L, D)
            mixed = share * clean[apart] + (1 - share) * of_right  # (S, L, D)
            return clean.index_copy(0, apart, mixed)

        return denoise

    return listen_both


def left_share(channel: str) -> float:
    """How much of a channel is the left half's: 1, 0, or one half where it has no side."""
    sideless = channel in DIRECTIONS or channel.startswith(TOGETHER)
    if sideless or not channel.endswith(("Left", "Right")):
        return 0.5
    return float(channel.endswith("Left"))
