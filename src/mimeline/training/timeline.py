"""How the timeline model is trained: to see the motion through noise, told some of the timeline."""

from collections.abc import Mapping, Sequence
from typing import Any

import torch
from torch import Tensor

from mimeline.dataset.windows import Batch, Clip, random_batches
from mimeline.diffusion.conversions import add_noise
from mimeline.models.timeline import TimelineModel
from mimeline.training.conditions import drop_regions
from mimeline.training.loop import Run, fit


def denoising_loss(
    model: TimelineModel,
    batch: Batch,
    timeline: Tensor,
    generator: torch.Generator,
) -> Tensor:
    """Mean square error of the predicted clean motion (Ma et al. 2025, equation 1).

    timeline (B, L, 16): the batch's, or what condition dropout left of it. Steps are drawn evenly;
    the mean is over the measured values, which lie in valid frames.
    """
    step = torch.randint(len(model.schedule), (len(batch.motion),), generator=generator)  # (B,)
    eps = torch.randn(batch.motion.shape, generator=generator)  # (B, L, D)
    noisy = add_noise(batch.motion, eps, *model.schedule.at(step, batch.motion))
    error = (model(noisy, step, timeline, batch.valid) - batch.motion).square()  # (B, L, D)
    frames = error.masked_fill(~batch.measured, 0.0).mean(dim=-1)  # (B, L)
    share = batch.measured[batch.valid].float().mean()  # of the values of valid frames
    return frames[batch.valid].mean() / share


def train_timeline(
    model: TimelineModel,
    train: Sequence[Clip],
    val: Sequence[Clip],
    options: Mapping[str, Any],
) -> Run:
    """Initialise and train the model on random crops; options: the keys of its config section.

    The validation loss is that of one fixed batch with all its timelines and fixed noise.
    """
    generator = torch.Generator().manual_seed(options["seed"])
    batches = random_batches(train, options["window"], options["batch"], generator)

    def loss(model: TimelineModel, batch: Batch) -> Tensor:
        told = drop_regions(
            batch.timeline,
            options["drop_all"],
            options["drop_none"],
            options["drop_each"],
            generator,
        )
        return denoising_loss(model, batch, told, generator)

    def fixed() -> torch.Generator:
        return torch.Generator().manual_seed(options["seed"])

    held = next(random_batches(val, options["window"], options["batch"], fixed())) if val else None

    @torch.no_grad()
    def validate(model: TimelineModel) -> float | None:
        if held is None:
            return None
        return denoising_loss(model, held, held.timeline, fixed()).item()

    return fit(
        model.initialise(generator),
        batches,
        loss,
        validate,
        steps=options["steps"],
        peak=options["learning_rate"],
        clip_norm=options["clip_norm"],
        ema=options["ema"],
    )
