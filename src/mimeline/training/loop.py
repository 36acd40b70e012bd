"""The training loop: batch, loss, backward, clip, step, average, log."""

import logging
import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import pandas as pd
import torch
from torch import Tensor, nn

from mimeline.dataset.windows import Batch
from mimeline.errors import MimelineError
from mimeline.training.average import Average

log = logging.getLogger(__name__)

PROGRESS_S = 10.0  # seconds between two lines of progress
LOGGED = 50  # rows of losses in a training
WARMUP = 0.05  # share of the steps in which the learning rate rises


class TrainingDiverged(MimelineError):
    """The loss is not a finite number any more."""


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
    model: nn.Module,
    batches: Iterator[Batch],
    loss: Callable[[nn.Module, Batch], Tensor],
    validate: Callable[[nn.Module], float | None],
    *,
    steps: int,
    peak: float,
    clip_norm: float,
    ema: float,
) -> Run:
    """Train the model in place for so many steps of AdamW.

    loss(model, batch) is a scalar; validate(averaged model) a number for the log, or None. peak is
    the largest learning rate, clip_norm the largest norm of a gradient, ema the decay of the
    averaged weights. Raises TrainingDiverged, with the batch's clips, where the loss is not finite.
    """
    optimiser = torch.optim.AdamW(
        model.parameters(), lr=peak, betas=(0.9, 0.99), weight_decay=1e-2, fused=True
    )
    average = Average(model, ema)
    every = max(1, steps // LOGGED)
    rows, recent = [], []
    started = said = time.monotonic()
    model.train()
    for step in range(steps):
        batch = next(batches)
        value = loss(model, batch)
        if not torch.isfinite(value):
            raise _diverged(step, value.item(), batch)
        optimiser.zero_grad(set_to_none=True)
        value.backward()
        torch.nn.utils.clip_grad_norm_(model.parameters(), clip_norm)
        rate = learning_rate(step, steps, peak)
        for group in optimiser.param_groups:
            group["lr"] = rate
        optimiser.step()
        average.update(model)

        recent.append(value.item())
        now = time.monotonic()
        if (step + 1) % every == 0 or step + 1 == steps:
            checked, mean = validate(average.model), sum(recent) / len(recent)
            rows.append((step + 1, mean, checked, rate, now - started))
            recent = []
        if now - said >= PROGRESS_S or step + 1 == steps:
            left = (now - started) / (step + 1) * (steps - step - 1)
            mean = sum(recent) / len(recent) if recent else rows[-1][1]
            log.info("step %d of %d, mean loss %.4f, %.0f s left", step + 1, steps, mean, left)
            said = now
    columns = ["step", "loss", "val_loss", "learning_rate", "seconds"]
    return Run(model.eval(), average.model, pd.DataFrame(rows, columns=columns))


def _diverged(step: int, value: float, batch: Batch) -> TrainingDiverged:
    return TrainingDiverged(
        ", ".join(sorted(set(batch.clip_ids))),
        place=f"training step {step + 1}",
        found=f"a loss of {value}",
        expected="a finite loss",
        remedy="Lower learning_rate, or look at the motion of these clips.",
    )
