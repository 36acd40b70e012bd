"""The transformer layer that the models share, with its positions and its diffusion step."""

import math

import torch
import torch.nn.functional as F
from torch import Tensor, nn

ROTARY_BASE = 100.0  # slowest turn of some 350 frames: longer than any window, short enough to tell

Turns = tuple[Tensor, Tensor]  # cosine and sine of `rotary_angles`
Heard = tuple[Tensor, Tensor]  # keys and values (B, heads, L, d / heads) of a condition's tokens


def step_embedding(step: Tensor, width: int) -> Tensor:
    """Sines and cosines of the diffusion step, (B,) → (B, width) (Ho et al. 2020, appendix B)."""
    frequency = torch.exp(
        -math.log(10_000) * torch.arange(width // 2, device=step.device) / (width // 2)
    )
    angle = step[:, None].float() * frequency  # (B, width / 2)
    return torch.cat([angle.cos(), angle.sin()], dim=-1)  # (B, width)


def rotary_angles(length: int, head_width: int, like: Tensor) -> Turns:
    """Cosine and sine of the turns at frames 0 … length − 1, (length, head_width / 2) each.

    Of the device and type of `like` (Su et al. 2021, equation 34).
    """
    frame = torch.arange(length, device=like.device)
    pairs = torch.arange(head_width // 2, device=like.device) / (head_width // 2)
    angle = frame[:, None] * ROTARY_BASE**-pairs  # float32: bfloat16 cannot count to 300
    return angle.cos().to(like.dtype), angle.sin().to(like.dtype)


def rotate(x: Tensor, turns: Turns) -> Tensor:
    """Turn each pair of x (..., L, head_width) by its frame's angles (Su et al. 2021, eq. 34)."""
    cos, sin = turns
    first, second = x.chunk(2, dim=-1)  # (..., L, head_width / 2) each
    return torch.cat([first * cos - second * sin, first * sin + second * cos], dim=-1)


class JointLayer(nn.Module):
    """A pre-norm encoder layer on [motion; condition], frame i of both at the same position.

    What the motion half reads of the condition half depends on neither motion nor diffusion step:
    `hear` works it out once for all steps. `forward` gives the motion half; `carry` the condition
    half, by the same weights, for those who hand it on to the next layer. The diffusion step scales
    and shifts what is read.
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

    def hear(self, control: Tensor, turns: Turns) -> Heard:
        """Keys and values of the condition's tokens (B, L, d)."""
        return self._keys(self.norm_control(control), turns)

    def forward(
        self, motion: Tensor, heard: Heard, step: Tensor, turns: Turns, visible: Tensor
    ) -> Tensor:
        """motion (B, L, d) · step (B, d) · visible (B, 1, L, 2L) bool → motion (B, L, d)."""
        own, level = self._own(motion, step)
        return self._update(motion, own, self._both(own, heard, turns), level, turns, visible)

    def carry(
        self,
        motion: Tensor,
        control: Tensor,
        heard: Heard,
        step: Tensor,
        turns: Turns,
        visible: Tensor,
    ) -> Tensor:
        """The condition's tokens (B, L, d) after this layer; motion as it was before it."""
        own, level = self._own(motion, step)
        both = self._both(own, heard, turns)
        return self._update(control, self.norm_control(control), both, level, turns, visible)

    def _own(self, motion: Tensor, step: Tensor) -> tuple[Tensor, tuple[Tensor, Tensor]]:
        scale, shift, *level = self.modulate(step)[:, None].chunk(4, dim=-1)  # (B, 1, d) each
        return self.norm_attention(motion) * (1 + scale) + shift, tuple(level)

    def _both(self, own: Tensor, heard: Heard, turns: Turns) -> Heard:
        """Keys and values of [motion; condition], (B, heads, 2L, d / heads)."""
        pairs = zip(self._keys(own, turns), heard, strict=True)
        return tuple(torch.cat(pair, dim=2) for pair in pairs)

    def _update(self, tokens, asking, both, level, turns, visible) -> Tensor:
        """tokens (B, L, d) after attention to both halves and the feed-forward step."""
        query = rotate(self._split(self.query(asking)), turns)  # (B, heads, L, d / heads)
        found = F.scaled_dot_product_attention(query, *both, attn_mask=visible)
        tokens = tokens + self.attended(found.transpose(1, 2).flatten(2))  # (B, L, d)
        scale, shift = level
        own = self.norm_feed(tokens) * (1 + scale) + shift  # (B, L, d)
        return tokens + self.fed(F.gelu(self.feed(own)))

    def _keys(self, tokens: Tensor, turns: Turns) -> Heard:
        key, value = (self._split(x) for x in self.key_value(tokens).chunk(2, dim=-1))
        return rotate(key, turns), value

    def _split(self, x: Tensor) -> Tensor:
        return x.unflatten(-1, (self.heads, -1)).transpose(1, 2)  # (B, heads, L, d / heads)
