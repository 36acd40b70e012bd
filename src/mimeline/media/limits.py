"""How much a file may ask of us, and the error that says it asks for more."""

from dataclasses import dataclass
from pathlib import Path

from mimeline.errors import BadFile


@dataclass(frozen=True)
class Limits:
    """max_pixels: width × height of a picture. max_source_s: length of a video, seconds.
    max_mb: size of a file, and of any file made from it. timeout_s: of each process that works on
    one: a look into it, a cut of its pictures, a cut of its sound."""

    max_pixels: int = 33_177_600
    max_source_s: float = 14_400.0
    max_mb: float = 8_000.0
    timeout_s: float = 300.0

    @property
    def max_bytes(self) -> int:
        return int(self.max_mb * 1e6)


class Refused(BadFile):
    """A file breaks a rule that has a number.

    rule: its name, one word. value, limit, unit: what was found and what is allowed.
    """

    def __init__(self, file, *, rule: str, value: float, limit: float, unit: str, **message: str):
        self.rule, self.value, self.limit, self.unit = rule, value, limit, unit
        super().__init__(file, **message)


def check_bytes(path: Path, size: int, limits: Limits) -> None:
    """Raises Refused if a file of size bytes is too large."""
    if size > limits.max_bytes:
        raise Refused(
            path,
            rule="too_many_bytes",
            value=size / 1e6,
            limit=limits.max_mb,
            unit="MB",
            found=f"{size / 1e6:.0f} MB",
            expected=f"at most {limits.max_mb:g} MB",
            remedy="Shorten the video, or raise fetch.max_mb.",
        )


def check_video(path: Path, width: int, height: int, length_s: float, limits: Limits) -> None:
    """Raises Refused if a video of width × height pixels and length_s seconds is too much."""
    if width * height > limits.max_pixels:
        raise Refused(
            path,
            rule="too_large",
            value=width * height,
            limit=limits.max_pixels,
            unit="px",
            found=f"a picture of {width} x {height} pixels",
            expected=f"at most {limits.max_pixels} pixels in all",
            remedy="Scale the video down, or raise fetch.max_pixels.",
        )
    if length_s > limits.max_source_s:
        raise Refused(
            path,
            rule="too_long_source",
            value=length_s,
            limit=limits.max_source_s,
            unit="s",
            found=f"a video of {length_s:.0f} s",
            expected=f"at most {limits.max_source_s:g} s",
            remedy="Shorten the video, or raise fetch.max_source_s.",
        )
