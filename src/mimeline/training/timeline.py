"""How the timeline model is trained: to see the motion through noise, told some of the timeline."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import torch
from torch import Tensor, from_numpy

from mimeline.dataset.windows import Batch, Clip, random_batches
from mimeline.diffusion.conversions import add_noise
from mimeline.diffusion.schedule import Schedule
from mimeline.models.timeline import TimelineModel
from mimeline.training.conditions import drop_regions
from mimeline.training.hardware import Hardware
from mimeline.training.lesson import Lesson, square_error
from mimeline.training.loop import Run, fit


def noised(
    batch: Batch, timeline: Tensor, schedule: Schedule, generator: torch.Generator
) -> Lesson:
    """The batch seen through noise; the target is its clean motion (Ma et al. 2025, equation 1).

    timeline (B, L, 16): the batch's, or what condition dropout left of it. Steps are drawn evenly.
    All measured values, which lie in valid frames, weigh the same.
    """
    step = torch.randint(len(schedule), (len(batch.motion),), generator=generator)  # (B,)
    eps = torch.randn(batch.motion.shape, generator=generator)  # (B, L, D)
    noisy = add_noise(batch.motion, eps, *schedule.at(step, batch.motion))
    weight = batch.measured / batch.measured.sum()  # (B, L, D)
    return Lesson(batch.clip_ids, (noisy, step, timeline, batch.valid), batch.motion, weight)


def train_timeline(
    model: TimelineModel,
    train: Sequence[Clip],
    val: Sequence[Clip],
    options: Mapping[str, Any],
    hardware: Hardware = Hardware(),  # noqa: B008 (it never changes)
    state: str | Path | None = None,
    tensorboard: str | Path | None = None,
) -> Run:
    """Initialise and train the model on random crops; options: the keys of its config section.

    The validation loss is that of one fixed batch with all its timelines and fixed noise.
    hardware, state, tensorboard: as `fit` takes them.
    """
    generator = torch.Generator().manual_seed(options["seed"])
    window, size, schedule = options["window"], options["batch"], model.schedule

    def lessons() -> Iterator[Lesson]:
        chances = (options["drop_all"], options["drop_none"], options["drop_each"])
        for batch in random_batches(train, window, size, generator):
            told = drop_regions(batch.timeline, *chances, generator)
            yield noised(batch, told, schedule, generator)

    def held() -> Lesson:
        fixed = [torch.Generator().manual_seed(options["seed"]) for _ in range(2)]
        batch = next(random_batches(val, window, size, fixed[0]))
        return noised(batch, batch.timeline, schedule, fixed[1])

    model.initialise(generator)
    model.jitter.measure((from_numpy(clip.motion), from_numpy(clip.measured)) for clip in train)
    return fit(
        model,
        lessons(),
        square_error,
        held() if val else None,
        generator,
        steps=options["steps"],
        peak=options["learning_rate"],
        clip_norm=options["clip_norm"],
        ema=options["ema"],
        save_every=options["save_every"],
        hardware=hardware,
        state=state,
        tensorboard=tensorboard,
    )
