"""What was found out about a file or folder."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Range:
    """What a channel does over a take: coefficients, or radians where angle.

    dead: it hardly moves. course: in each of a few equal stretches of the take the value that is
    farthest from rest (0, or the mean of an angle), None where no frame has one.
    """

    channel: str
    low: float
    mean: float
    high: float
    angle: bool
    dead: bool
    course: list[float | None]


@dataclass
class Inspection:
    """kind: what the path is. facts: name → what people read of it; numbers: the same, and more,
    for programs. rows: of a table, the first its head. ranges: of channels. notes: what a person
    should know; problems: what must be mended; error: why it could not be read.
    """

    path: Path
    kind: str
    facts: dict[str, str] = field(default_factory=dict)
    numbers: dict[str, Any] = field(default_factory=dict)
    rows: list[tuple[str, ...]] = field(default_factory=list)
    ranges: list[Range] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)
    error: str = ""

    @property
    def sound(self) -> bool:
        """Nothing is wrong with it."""
        return not self.problems and not self.error
