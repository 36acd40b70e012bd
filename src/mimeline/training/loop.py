"""The training loop: batch, loss, backward, clip, step, average, log, save."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
import torch
from torch import Tensor, nn

from mimeline.errors import MimelineError
from mimeline.training.average import Average
from mimeline.training.hardware import Hardware
from mimeline.training.journal import Journal
from mimeline.training.lesson import Lesson
from mimeline.training.state import State

WARMUP = 0.05  # share of the steps in which the learning rate rises


class TrainingDiverged(MimelineError):
    """The loss or its gradient is not a finite number any more."""


@dataclass(frozen=True)
class Run:
    """A finished training: the last weights, the averaged ones, and the losses (tables.LOSSES)."""

    model: nn.Module
    average: nn.Module
    losses: pd.DataFrame


def learning_rate(step: int, steps: int, peak: float) -> float:
    """Rises evenly over the first steps, then falls to a tenth along half a cosine."""
    warmup = max(1, round(WARMUP * steps))
    if step < warmup:
        return peak * (step + 1) / warmup
    done = (step - warmup) / max(1, steps - warmup)
    return peak * (0.1 + 0.45 * (1 + math.cos(math.pi * done)))


def fit(
    network: nn.Module,
    lessons: Iterator[Lesson],
    loss: Callable[[nn.Module, Lesson], Tensor],
    held: Lesson | None,
    generator: torch.Generator,
    *,
    steps: int,
    peak: float,
    clip_norm: float,
    ema: float,
    save_every: int,
    hardware: Hardware,
    state: str | Path | None,
    tensorboard: str | Path | None,
) -> Run:
    """Train the network in place for so many steps of AdamW, or for what is left of them.

    lessons: all that they draw at random comes from the generator when they are asked; every
    process asks for the same ones and works on its part. loss(model, lesson) is a scalar, and those
    of a lesson's parts add up to its own; on the held one it is the validation loss of the averaged
    weights. peak: largest learning rate. clip_norm: largest norm of the gradient. ema: decay of the
    averaged weights. state, tensorboard: folders of this training alone, for what resumes it,
    written each save_every steps, and for its curves; None: not kept.

    Raises TrainingDiverged, with the lesson's clips, where loss or gradient is not finite; NoRoom
    where a disk is full.
    """
    accelerator = hardware.accelerator()
    rank, processes, device = (
        accelerator.process_index,
        accelerator.num_processes,
        accelerator.device,
    )
    network.to(device).train()
    average = Average(network, ema)
    optimiser = torch.optim.AdamW(
        network.parameters(), lr=peak, betas=(0.9, 0.99), weight_decay=1e-2, fused=True
    )
    model, stepper = accelerator.prepare(network, optimiser)
    check = held and held.part(0, 1, device)
    journal = Journal(steps, None if rank else tensorboard)
    saved = State(state, network, average, optimiser, accelerator.scaler, generator, journal)
    for step in range(saved.resume() + 1, steps + 1):
        lesson = next(lessons)
        own = loss(model, lesson.part(rank, processes, device))
        accelerator.backward(processes * own)  # gradients are averaged over the processes
        norm = accelerator.clip_grad_norm_(network.parameters(), clip_norm)
        total = accelerator.reduce(own.detach(), "sum").item()
        if not math.isfinite(total) or not (norm.isfinite() or _too_large(accelerator.scaler)):
            raise _diverged(step, total, norm.item(), lesson)
        rate = learning_rate(step - 1, steps, peak)
        for group in optimiser.param_groups:
            group["lr"] = rate
        stepper.step()
        stepper.zero_grad()
        average.update(network)

        if rank == 0:
            journal.note(step, total, norm.item(), rate, lambda: _validate(average, loss, check))
            if step % save_every == 0 or step == steps:
                saved.save(step)
    accelerator.unwrap_model(model, keep_fp32_wrapper=False)  # the network as it was
    return Run(network.eval().cpu(), average.model.cpu(), journal.losses())


@torch.no_grad()
def _validate(average: Average, loss, held: Lesson | None) -> float | None:
    return None if held is None else loss(average.model, held).item()


def _too_large(scaler: torch.amp.GradScaler | None) -> bool:
    """Whether a gradient is only too large for float16: its step is skipped, the next scaled less.

    Below a scale of one the fault is not float16's.
    """
    return scaler is not None and scaler.get_scale() >= 1


def _diverged(step: int, loss: float, norm: float, lesson: Lesson) -> TrainingDiverged:
    found = f"a gradient of norm {norm}" if math.isfinite(loss) else f"a loss of {loss}"
    return TrainingDiverged(
        ", ".join(sorted(set(lesson.clip_ids))),
        place=f"training step {step}",
        found=found,
        expected="a finite number",
        remedy="Lower learning_rate, or look at the motion of these clips.",
    )
