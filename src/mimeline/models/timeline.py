"""The timeline model: a base network for what moves together, a branch per part of the face."""

import math
from collections.abc import Callable, Sequence
from typing import Literal

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from mimeline.diffusion.conversions import clean_from_velocity
from mimeline.diffusion.samplers import Denoiser
from mimeline.diffusion.schedule import SCHEDULES
from mimeline.models.divisions import Division, parts, whole
from mimeline.models.jitter import Jitter
from mimeline.models.layers import JointLayer, Turns, rotary_angles, step_embedding
from mimeline.vocabulary import ACTIONS, UNKNOWN

Run = Callable[[Tensor, Tensor], Tensor]  # motion tokens (B, L, d), level (B, d) → (B, L, d)


class Network(nn.Module):
    """Layers that read motion tokens and the tokens of a timeline.

    Each reads the initial timeline tokens anew (Ma et al. 2025, section 3.2), or, where they are
    carried, what the layer before made of them (Table 2, "w/o time con.").
    """

    def __init__(self, n_actions: int, width: int, heads: int, layers: int, carried: bool):
        super().__init__()
        self.carried = carried
        self.embed_timeline = nn.Linear(2 * n_actions, width)  # its bias says "I am a timeline"
        self.layers = nn.ModuleList(JointLayer(width, heads) for _ in range(layers))

    def listen(self, timeline: Tensor, turns: Turns, visible: Tensor) -> Run:
        """What the layers make of motion tokens (B, L, d) at a level (B, d), told this timeline.

        timeline (B, L, n_actions) in {0, 1}, -1 unknown · visible (B, 1, L, 2L) bool. What depends
        on neither motion nor level is worked out here, once.
        """
        # One input says "asked for", one "unknown": on one line from -1 to 1 "absent" would lie
        # between the two.
        state = torch.cat([timeline == 1, timeline == UNKNOWN], dim=-1)  # (B, L, 2 n_actions)
        initial = self.embed_timeline(state.to(self.embed_timeline.weight.dtype))  # (B, L, d)
        heard = [layer.hear(initial, turns) for layer in self.layers[: 1 if self.carried else None]]

        def run(motion: Tensor, level: Tensor) -> Tensor:
            for layer, own in zip(self.layers, heard, strict=True):
                motion = layer(motion, own, level, turns, visible)  # (B, L, d)
            return motion

        def run_carried(motion: Tensor, level: Tensor) -> Tensor:
            control, (own,) = initial, heard
            for number, layer in enumerate(self.layers):
                own = layer.hear(control, turns) if number else own
                before, motion = motion, layer(motion, own, level, turns, visible)  # (B, L, d)
                if layer is not self.layers[-1]:
                    control = layer.carry(before, control, own, level, turns, visible)  # (B, L, d)
            return motion

        return run_carried if self.carried else run


class TimelineModel(nn.Module):
    """Base-branch denoiser (Ma et al. 2025, section 3.2, figure 3).

    channels: names of the motion's columns, in order. width: of the tokens, a multiple of twice
    the heads. base_layers, branch_layers: depth of the base network and of each branch. Without a
    base, each branch sees the noisy motion of its own channels alone; without branches, the base
    makes the whole face. branches: how the face is divided among them (`parts`). timeline_tokens:
    which ones a layer reads, the initial ones or those of the layer before. schedule,
    diffusion_steps: a name of SCHEDULES and its steps; the noise schedule is the model's own.

    Raises ValueError where there is neither base nor branch.
    """

    def __init__(
        self,
        channels: Sequence[str],
        width: int,
        heads: int,
        base_layers: int,
        branch_layers: int,
        branches: Division,
        timeline_tokens: Literal["initial", "carried"],
        schedule: str,
        diffusion_steps: int,
    ):
        super().__init__()
        if not base_layers and not branch_layers:
            raise ValueError("a model needs a base or branches")
        self.schedule = SCHEDULES[schedule](diffusion_steps)
        self.channels = tuple(channels)
        self.head_width = width // heads
        self.parts = parts(channels, branches) if branch_layers else whole(channels)

        def network(n_actions: int, layers: int) -> Network:
            return Network(n_actions, width, heads, layers, timeline_tokens == "carried")

        self.embed_step = nn.Sequential(nn.Linear(width, width), nn.SiLU(), nn.Linear(width, width))
        self.keep = nn.Linear(width, len(self.channels))
        columns = {name: part.columns for name, part in self.parts.items()}
        self.jitter = Jitter(len(self.channels), columns)
        self.base = network(len(ACTIONS), base_layers) if base_layers else None
        sources = whole(channels) if base_layers else self.parts  # of motion tokens
        self.embed_motion = nn.ModuleDict(
            {name: nn.Linear(len(part.columns), width) for name, part in sources.items()}
        )
        self.branches = nn.ModuleDict(
            {
                name: network(len(part.actions), branch_layers)
                for name, part in self.parts.items()
                if branch_layers
            }
        )
        self.norms = nn.ModuleDict({name: nn.LayerNorm(width) for name in self.parts})
        self.outputs = nn.ModuleDict(
            {name: nn.Linear(width, len(part.columns)) for name, part in self.parts.items()}
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
        return self.listen(timeline, valid)(noisy, step)

    def listen(self, timeline: Tensor, valid: Tensor) -> Denoiser:
        """The denoiser of these timelines (B, L, 16), for any step.

        What the layers read of the timelines is the same at all steps, and is worked out once.
        """
        weight = self.keep.weight
        turns = rotary_angles(timeline.shape[1], self.head_width, weight)
        visible = visible_tokens(valid)  # (B, 1, L, 2L)
        base = self.base.listen(timeline, turns, visible) if self.base else None
        branches = {
            name: branch.listen(timeline[..., self.parts[name].actions], turns, visible)
            for name, branch in self.branches.items()
        }

        def denoise(noisy: Tensor, step: Tensor) -> Tensor:
            level = self.embed_step(step_embedding(step, weight.shape[1]).to(weight.dtype))
            level = F.silu(level)  # (B, d)
            seen = noisy.to(weight.dtype)  # (B, L, D)
            common = base(self.embed_motion["face"](seen), level) if base else None  # (B, L, d)
            motion = torch.empty_like(noisy)  # (B, L, D)
            for name, part in self.parts.items():
                own = self.embed_motion[name](seen[..., part.columns]) if common is None else common
                own = branches[name](own, level) if branches else own  # (B, L, d)
                made = self.outputs[name](self.norms[name](own))  # (B, L, D of the part)
                motion[..., part.columns] = made.to(noisy.dtype)
            # Little noise is best told as the noisy value, corrected (Salimans & Ho 2022, section
            # 4), much noise as what the layers made of all. Each channel learns its mixture.
            signal, noise = self.schedule.at(step, noisy)  # (B, 1, 1) each
            keep = self.keep(level)[:, None].sigmoid().to(noisy.dtype)  # (B, 1, D)
            kept = clean_from_velocity(noisy, -motion, signal, noise)  # (B, L, D)
            motion = keep * kept + (1 - keep) * motion
            return self.jitter(noisy, motion, signal, noise)

        return denoise


def visible_tokens(valid: Tensor) -> Tensor:
    """Which tokens [motion; timeline] a frame may attend to, valid (B, L) → (B, 1, L, 2L) bool.

    A frame always sees itself: a frame of padding that saw nothing would be NaN and spread.
    """
    itself = torch.eye(valid.shape[1], dtype=torch.bool, device=valid.device)
    half = valid[:, None, None, :] | itself  # (B, 1, L, L)
    return torch.cat([half, half], dim=-1)  # (B, 1, L, 2L)
