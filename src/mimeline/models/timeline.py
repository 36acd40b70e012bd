"""The timeline model: a base network for what moves together, a branch per part of the face."""

import math
from collections.abc import Sequence

import torch
from torch import Tensor, nn

from mimeline.diffusion.schedule import cosine
from mimeline.models.layers import JointLayer, rotary_angles, step_embedding
from mimeline.vocabulary import ACTIONS, CHANNELS, OUTPUT_GROUPS, UNKNOWN

# What each branch sees of the timeline (Ma et al. 2025, section 3.2): the head moves along with
# everything, so the rest sees all.
SEEN_REGIONS: dict[str, tuple[str, ...]] = {
    "upper": ("brow", "eye", "gaze"),
    "lower": ("mouth",),
    "rest": ("brow", "eye", "mouth", "gaze", "head"),
}
assert set(SEEN_REGIONS) == set(OUTPUT_GROUPS)


def seen_actions(group: str) -> list[int]:
    """Columns of the timeline that an output group's branch sees, in Table 1 order."""
    return [i for i, a in enumerate(ACTIONS.values()) if a.control_region in SEEN_REGIONS[group]]


class Network(nn.Module):
    """Layers that read motion tokens and, anew at each layer, the initial timeline tokens."""

    def __init__(self, n_actions: int, width: int, heads: int, layers: int):
        super().__init__()
        self.embed_timeline = nn.Linear(2 * n_actions, width)  # its bias says "I am a timeline"
        self.layers = nn.ModuleList(JointLayer(width, heads) for _ in range(layers))

    def forward(
        self,
        motion: Tensor,
        timeline: Tensor,
        step: Tensor,
        turns: tuple[Tensor, Tensor],
        visible: Tensor,
    ) -> Tensor:
        """motion (B, L, d) · timeline (B, L, n_actions) · step (B, d) → (B, L, d)."""
        # One input says "asked for", one "unknown": on one line from -1 to 1 "absent" would lie
        # between the two.
        state = torch.cat([timeline == 1, timeline == UNKNOWN], dim=-1).to(motion.dtype)
        control = self.embed_timeline(state)  # (B, L, d)
        for layer in self.layers:
            motion = layer(motion, control, step, turns, visible)  # (B, L, d)
        return motion


class TimelineModel(nn.Module):
    """Base-branch denoiser (Ma et al. 2025, section 3.2, figure 3).

    channels: names of the motion's columns, in order. width: of the tokens, a multiple of twice
    the heads. base_layers, branch_layers: depth of the base network and of each branch.
    diffusion_steps: of the noise schedule, which is the model's own.
    """

    def __init__(
        self,
        channels: Sequence[str],
        width: int,
        heads: int,
        base_layers: int,
        branch_layers: int,
        diffusion_steps: int,
    ):
        super().__init__()
        self.schedule = cosine(diffusion_steps)
        self.channels = tuple(channels)
        self.head_width = width // heads
        groups = [CHANNELS[name].output_group for name in self.channels]
        self.columns = {
            group: [i for i, own in enumerate(groups) if own == group]
            for group in OUTPUT_GROUPS
            if group in groups
        }
        self.seen = {group: seen_actions(group) for group in self.columns}

        self.embed_motion = nn.Linear(len(self.channels), width)
        self.embed_step = nn.Sequential(nn.Linear(width, width), nn.SiLU(), nn.Linear(width, width))
        self.keep = nn.Linear(width, len(self.channels))
        self.base = Network(len(ACTIONS), width, heads, base_layers)
        self.branches = nn.ModuleDict(
            {g: Network(len(self.seen[g]), width, heads, branch_layers) for g in self.columns}
        )
        self.norms = nn.ModuleDict({g: nn.LayerNorm(width) for g in self.columns})
        self.outputs = nn.ModuleDict(
            {g: nn.Linear(width, len(columns)) for g, columns in self.columns.items()}
        )

    def initialise(self, generator: torch.Generator) -> "TimelineModel":
        """Draw the weights; every parameter is set here, so that a seed settles them all."""
        for module in self.modules():
            if isinstance(module, nn.Linear):
                # Keeps the size of what passes through a layer, whatever the widths.
                nn.init.xavier_uniform_(module.weight, generator=generator)
                nn.init.zeros_(module.bias)
            elif isinstance(module, nn.LayerNorm) and module.elementwise_affine:
                nn.init.ones_(module.weight)
                nn.init.zeros_(module.bias)
        for module in self.modules():
            if isinstance(module, Network):
                # Timeline tokens differ from motion tokens before either says anything.
                nn.init.normal_(module.embed_timeline.bias, std=0.5, generator=generator)
            if isinstance(module, JointLayer):
                # No modulation: at the start every diffusion step sees the same layer.
                nn.init.zeros_(module.modulate.weight)
                # Equal constants in query and key turn with their frames and match best where the
                # frames are near: attention starts out looking at its own frame.
                near = math.sqrt(2.0)
                nn.init.constant_(module.query.bias, near)
                nn.init.constant_(module.key_value.bias[: len(module.query.bias)], near)
        for output in self.outputs.values():
            # At first the layers say nothing: the loss starts no higher than the data's variance.
            nn.init.zeros_(output.weight)
        # Every channel starts in the middle between keeping its noisy value and not.
        nn.init.zeros_(self.keep.weight)
        return self

    def forward(self, noisy: Tensor, step: Tensor, timeline: Tensor, valid: Tensor) -> Tensor:
        """Predict the clean motion (Ma et al. 2025, equation 1).

        noisy (B, L, D) · step (B,) · timeline (B, L, 16) in {0, 1}, -1 where dropped or not
        measured · valid (B, L) bool. Returns (B, L, D); frames that are not valid mean nothing.
        """
        frame = torch.arange(noisy.shape[1], device=noisy.device).repeat(2)  # (2L,)
        turns = rotary_angles(frame, self.head_width)
        visible = visible_tokens(valid)  # (B, 1, L, 2L)
        level = nn.functional.silu(
            self.embed_step(step_embedding(step, self.embed_step[0].in_features))
        )  # (B, d)

        base = self.base(self.embed_motion(noisy), timeline, level, turns, visible)  # (B, L, d)
        signal, noise = self.schedule.at(step, noisy)  # (B, 1, 1) each
        keep = self.keep(level)[:, None].sigmoid()  # (B, 1, D)
        motion = torch.empty_like(noisy)  # (B, L, D)
        for group, branch in self.branches.items():
            own = branch(base, timeline[..., self.seen[group]], level, turns, visible)  # (B, L, d)
            motion[..., self.columns[group]] = self.outputs[group](self.norms[group](own))
        # A channel that is mostly jitter is best told as its noisy value, corrected (Salimans & Ho
        # 2022, section 4); a smooth one as what the layers made of all. Each learns its mixture.
        return keep * (signal * noisy + noise * motion) + (1 - keep) * motion


def visible_tokens(valid: Tensor) -> Tensor:
    """Which tokens [motion; timeline] a frame may attend to, valid (B, L) → (B, 1, L, 2L) bool.

    A frame always sees itself: a frame of padding that saw nothing would be NaN and spread.
    """
    itself = torch.eye(valid.shape[1], dtype=torch.bool, device=valid.device)
    half = valid[:, None, None, :] | itself  # (B, 1, L, L)
    return torch.cat([half, half], dim=-1)  # (B, 1, L, 2L)
