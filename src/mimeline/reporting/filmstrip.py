"""A row of square pictures that fills a time axis: each shows the frame at its middle."""

from dataclasses import dataclass

from mimeline.reporting.drawing import Scale

EDGE = 58.0  # of a picture, about


@dataclass(frozen=True)
class Place:
    """x: left edge; edge: width and height, in the axis' units."""

    frame: int
    x: float
    edge: float


def places(first: int, end: int, x: Scale) -> list[Place]:
    """Places that fill the axis x from frame `first` to frame `end`."""
    left, right = x(first), x(end)
    count = max(1, round((right - left) / EDGE))
    edge = (right - left) / count
    return [
        Place(
            min(int(first + (end - first) * (number + 0.5) / count), end - 1),
            round(left + edge * number, 1),
            round(edge, 1),
        )
        for number in range(count)
    ]
