"""A part of a picture."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Box:
    """Edges in pixels from the picture's top left; they may lie outside and between pixels."""

    top: float
    bottom: float
    left: float
    right: float

    @classmethod
    def whole(cls, width: int, height: int) -> "Box":
        """The whole picture."""
        return cls(0, height, 0, width)

    @classmethod
    def of_shares(
        cls, top: float, bottom: float, left: float, right: float, width: int, height: int
    ) -> "Box":
        """A box given in shares of a picture of width × height pixels."""
        return cls(top * height, bottom * height, left * width, right * width)

    def within(self, width: int, height: int) -> tuple[int, int, int, int]:
        """The part of the box inside the picture: left, top, width, height in whole pixels.

        Width and height are even, as video needs them; 0 where the box lies outside.
        """
        left, wide = _span(self.left, self.right, width)
        top, high = _span(self.top, self.bottom, height)
        return left, top, wide, high


def _span(since: float, until: float, size: int) -> tuple[int, int]:
    """First pixel and even number of pixels of an edge's span, kept within 0..size."""
    first, last = (round(min(max(edge, 0), size)) for edge in (since, until))
    return first, max(last - first, 0) // 2 * 2
