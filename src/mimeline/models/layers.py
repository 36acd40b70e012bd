"""The transformer layer that the models share, with its positions and its diffusion step."""

import math

import torch
import torch.nn.functional as F
from torch import Tensor, nn

ROTARY_BASE = 100.0  # slowest turn of some 350 frames: longer than any window, short enough to tell


def step_embedding(step: Tensor, width: int) -> Tensor:
    """Sines and cosines of the diffusion step, (B,) → (B, width) (Ho et al. 2020, appendix B)."""
    frequency = torch.exp(
        -math.log(10_000) * torch.arange(width // 2, device=step.device) / (width // 2)
    )
    angle = step[:, None].float() * frequency  # (B, width / 2)
    return torch.cat([angle.cos(), angle.sin()], dim=-1)  # (B, width)


def rotary_angles(frame: Tensor, head_width: int) -> tuple[Tensor, Tensor]:
    """Cosine and sine of the turns at frames (N,) → (N, head_width / 2) each (Su et al. 2021)."""
    pairs = torch.arange(head_width // 2, device=frame.device) / (head_width // 2)
    angle = frame[:, None] * ROTARY_BASE**-pairs
    return angle.cos(), angle.sin()


def rotate(x: Tensor, turns: tuple[Tensor, Tensor]) -> Tensor:
    """Turn each pair of x (..., N, head_width) by its frame's angles (Su et al. 2021, eq. 34)."""
    cos, sin = turns
    first, second = x.chunk(2, dim=-1)  # (..., N, head_width / 2) each
    return torch.cat([first * cos - second * sin, first * sin + second * cos], dim=-1)


class JointLayer(nn.Module):
    """A pre-norm encoder layer on [motion; timeline] of which the motion half goes on.

    Only the motion half asks: what the timeline half would find is thrown away, since every layer
    starts from the initial timeline tokens again (Ma et al. 2025, section 3.2). The same turns on
    both halves let frame i find frame i. The diffusion step scales and shifts what each half of
    the layer reads.
    """

    def __init__(self, width: int, heads: int):
        super().__init__()
        self.heads = heads
        self.norm_attention = nn.LayerNorm(width, elementwise_affine=False)
        self.norm_control = nn.LayerNorm(width)
        self.norm_feed = nn.LayerNorm(width, elementwise_affine=False)
        self.modulate = nn.Linear(width, 4 * width)
        self.query = nn.Linear(width, width)
        self.key_value = nn.Linear(width, 2 * width)
        self.attended = nn.Linear(width, width)
        self.feed = nn.Linear(width, 2 * width)
        self.fed = nn.Linear(2 * width, width)

    def forward(
        self,
        motion: Tensor,
        control: Tensor,
        step: Tensor,
        turns: tuple[Tensor, Tensor],
        visible: Tensor,
    ) -> Tensor:
        """motion, control (B, L, d) · step (B, d) · visible (B, 1, L, 2L) bool → (B, L, d).

        turns: `rotary_angles` of both halves, (2L, d / heads / 2) each.
        """
        length = motion.shape[1]
        scale, shift, feed_scale, feed_shift = self.modulate(step)[:, None].chunk(
            4, dim=-1
        )  # (B, 1, d)
        own = self.norm_attention(motion) * (1 + scale) + shift  # (B, L, d)
        both = torch.cat([own, self.norm_control(control)], dim=1)  # (B, 2L, d)

        query = self._split(self.query(own))  # (B, heads, L, d / heads)
        key, value = (self._split(x) for x in self.key_value(both).chunk(2, dim=-1))
        query = rotate(query, (turns[0][:length], turns[1][:length]))
        found = F.scaled_dot_product_attention(query, rotate(key, turns), value, attn_mask=visible)
        motion = motion + self.attended(found.transpose(1, 2).flatten(2))  # (B, L, d)

        own = self.norm_feed(motion) * (1 + feed_scale) + feed_shift  # (B, L, d)
        return motion + self.fed(F.gelu(self.feed(own)))

    def _split(self, x: Tensor) -> Tensor:
        return x.unflatten(-1, (self.heads, -1)).transpose(1, 2)  # (B, heads, ·, d / heads)
