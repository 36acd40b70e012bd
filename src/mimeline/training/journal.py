"""What a training tells while it runs: rows of losses, curves for TensorBoard, words in the log."""

import logging
import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pandas as pd

from mimeline.progress import duration
from mimeline.room import room
from mimeline.training.curves import Curves

log = logging.getLogger(__name__)

PROGRESS_S = 10.0  # seconds between two words
ROWS, FARTHEST = 50, 250  # rows of a short training, steps between two of a long one
COLUMNS = ("step", "loss", "val_loss", "learning_rate", "gradient_norm", "seconds")


class Journal:
    """The course of a training of so many steps.

    A row is told when ROWS of them fill the training, or FARTHEST steps after the last. Its loss
    and gradient norm (before clipping) are means over the steps since the last row.
    curves: a folder for TensorBoard; None: no curves.
    """

    def __init__(self, steps: int, curves: str | Path | None):
        self.steps = steps
        self.every = min(max(1, steps // ROWS), FARTHEST)
        self.rows: list[list[float | None]] = []
        self.recent: list[tuple[float, float]] = []  # loss and gradient norm since the last row
        self.began = self.said = time.monotonic()
        self.said_step = 0
        self.folder, self.curves = curves, None

    def note(
        self,
        step: int,
        loss: float,
        gradient_norm: float,
        learning_rate: float,
        validate: Callable[[], float | None],
    ) -> None:
        """Take down a step, counted from one; validate() is asked for where a row is due."""
        self.recent.append((loss, gradient_norm))
        if step % self.every == 0 or step == self.steps:
            losses, norms = zip(*self.recent, strict=True)
            row = [step, _mean(losses), validate(), learning_rate, _mean(norms), self.seconds]
            self.rows.append(row)
            self.recent = []
            self._draw()
        if time.monotonic() - self.said >= PROGRESS_S or step == self.steps:
            self._say(step)

    @property
    def seconds(self) -> float:
        """Since the start, without the time that an interrupted training lay still."""
        return time.monotonic() - self.began

    def losses(self) -> pd.DataFrame:
        """The rows (tables.LOSSES)."""
        return pd.DataFrame(self.rows, columns=list(COLUMNS))

    def facts(self) -> dict[str, Any]:
        """What `resume` needs."""
        return {"rows": self.rows, "recent": self.recent, "seconds": self.seconds}

    def resume(self, step: int, facts: dict[str, Any]) -> None:
        """Go on after that step."""
        log.info("resumed at step %d of %d", step, self.steps)
        self.rows, self.said_step = facts["rows"], step
        self.recent = [(loss, norm) for loss, norm in facts["recent"]]
        self.began = time.monotonic() - facts["seconds"]

    def _draw(self) -> None:
        """Add the last row to the curves; the first time, all rows."""
        if self.folder is None:
            return
        with room(self.folder, "the curves of the training"):
            first = len(self.rows) - 1
            if self.curves is None:
                self.curves, first = Curves(self.folder, time.time() - self.seconds), 0
            for number in range(first, len(self.rows)):
                self.curves.add(self.rows[number], self.rows[number - 1] if number else None)

    def _say(self, step: int) -> None:
        now = time.monotonic()
        rate = (step - self.said_step) / max(now - self.said, 1e-9)  # steps a second, of late
        loss = self.recent[-1][0] if self.recent else self.rows[-1][1]
        left = duration((self.steps - step) / rate)
        log.info(
            "step %d of %d, loss %.4g, %.3g steps/s, %s",
            *(step, self.steps, loss, rate),
            f"about {left} left" if step < self.steps else f"done after {duration(self.seconds)}",
        )
        self.said, self.said_step = now, step


def _mean(values: tuple[float, ...]) -> float | None:
    """Of the finite ones: float16 skips a step whose gradient is too large for it."""
    finite = [value for value in values if math.isfinite(value)]
    return sum(finite) / len(finite) if finite else None
