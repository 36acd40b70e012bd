"""How far a long piece of work is, and how long it will take."""

import logging
import time
from collections.abc import Iterator, Sequence
from typing import TypeVar

Item = TypeVar("Item")
EVERY_S = 15.0  # seconds between two words


def told(items: Sequence[Item], what: str, log: logging.Logger) -> Iterator[Item]:
    """The items, one by one; now and then the log says how many are done and what time is left."""
    began = said = time.monotonic()
    for number, item in enumerate(items):
        if (now := time.monotonic()) - said > EVERY_S and number:
            left_s = (now - began) / number * (len(items) - number)
            log.info("%d of %d %s, about %s left", number, len(items), what, duration(left_s))
            said = now
        yield item


def duration(seconds: float) -> str:
    """Seconds as people say them: 50 s, 12 min, 3.4 h."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"
