"""A value against its limit, as a bar with a mark."""

import math
from dataclasses import dataclass

WIDTH = 64


@dataclass(frozen=True)
class Gauge:
    """value, limit: places on a scale that starts at 0, in [0, WIDTH]."""

    value: float
    limit: float

    @property
    def low(self) -> float:
        """The smaller of both: from here to the larger is what the rule objects to."""
        return min(self.value, self.limit)

    @property
    def high(self) -> float:
        return max(self.value, self.limit)

    @property
    def over(self) -> bool:
        """The value is past the limit, not short of it."""
        return self.value > self.limit


def gauge(value: float | None, limit: float | None) -> Gauge | None:
    """The larger of both fills the width; None where one is missing, negative or not finite."""
    numbers = [value, limit]
    if any(n is None or not math.isfinite(n) or n < 0 for n in numbers):
        return None
    largest = max(numbers)
    if not largest:
        return None
    return Gauge(*(round(WIDTH * float(n) / largest, 1) for n in numbers))
