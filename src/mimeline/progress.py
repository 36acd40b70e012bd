"""How far a long piece of work is, and how long it will take."""

import logging
import time
from collections.abc import Iterator, Sequence
from typing import TypeVar

Item = TypeVar("Item")
EVERY_S = 15.0  # seconds between two words


class Pace:
    """Says now and then how many things of a total are done, and what time is left."""

    def __init__(self, total: int, what: str, log: logging.Logger):
        self.total, self.done, self._what, self._log = total, 0, what, log
        self._began = self._said = time.monotonic()

    def step(self) -> None:
        """One more is done."""
        self.done += 1
        now = time.monotonic()
        if now - self._said > EVERY_S and self.done < self.total:
            left_s = (now - self._began) / self.done * (self.total - self.done)
            counted = self.done, self.total, self._what
            self._log.info("%d of %d %s, about %s left", *counted, duration(left_s))
            self._said = now


def told(items: Sequence[Item], what: str, log: logging.Logger) -> Iterator[Item]:
    """The items, one by one; now and then the log says how many are done and what time is left."""
    pace = Pace(len(items), what, log)
    for item in items:
        yield item
        pace.step()


def duration(seconds: float) -> str:
    """Seconds as people say them: 50 s, 12 min, 3.4 h."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"
