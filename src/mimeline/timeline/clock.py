"""The frame clock: frame rates as people write them, frames as seconds and back."""

import re
from fractions import Fraction

# What is said in decimals and means a thousand and one parts (SMPTE ST 12-1).
SPOKEN = {
    "23.976": Fraction(24000, 1001),
    "23.98": Fraction(24000, 1001),
    "29.97": Fraction(30000, 1001),
    "59.94": Fraction(60000, 1001),
}
# Below it the milliseconds of two frames are never the same, and lead back to their frames.
MILLISECOND_RATE = 1000
MOST_FRAMES = 10**12  # more than any clip has

_RATE = re.compile(r"[0-9]{1,6}(?:\.[0-9]{1,6}|/[0-9]{1,6})?")
_SECONDS = re.compile(
    r"[+-]?(?:[0-9]{1,12}(?:\.[0-9]{0,40})?|\.[0-9]{1,40})(?:[eE][+-]?[0-9]{1,2})?"
)


def frame_rate(text: str) -> Fraction:
    """Frames per second as they are written: 25, 30000/1001, or 29.97, which means the same.

    Raises ValueError for anything else.
    """
    text = text.strip()
    if text in SPOKEN:
        return SPOKEN[text]
    try:
        rate = Fraction(text) if _RATE.fullmatch(text) else Fraction(0)
    except ZeroDivisionError:
        rate = Fraction(0)
    if not rate:
        raise ValueError(f"{text!r} is no frame rate: write 25 or 30000/1001")
    return rate


def seconds(text: str) -> Fraction:
    """Seconds as a decimal number, exactly. Raises ValueError for what is none."""
    if not _SECONDS.fullmatch(text):
        raise ValueError(f"{text!r} is no number of seconds")
    return Fraction(text)


def nearest_frame(time: Fraction, fps: Fraction) -> int:
    """The frame whose start is nearest to a time in seconds; the later one of two."""
    parts = time.denominator * fps.denominator
    return (2 * time.numerator * fps.numerator + parts) // (2 * parts)  # fractions cost too much


def milliseconds(frame: int, fps: Fraction) -> int:
    """When a frame starts, in whole milliseconds; half of one counts as one.

    Raises ValueError where such a time is not nearest to the frame it was made of.
    """
    if fps >= MILLISECOND_RATE:
        raise ValueError(f"{fps} frames per second, which milliseconds do not tell apart")
    return (2000 * frame * fps.denominator + fps.numerator) // (2 * fps.numerator)
