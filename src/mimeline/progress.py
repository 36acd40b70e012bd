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
            log.info("%d of %d %s, about %d s left", number, len(items), what, round(left_s))
            said = now
        yield item
