"""STMC's text form: a line per interval, `BrowUp # 0.5 # 2.0 # brow`, times in seconds.

Timelines of several clips are set apart by empty lines. Source: Petrovich et al. 2024, README of
nv-tlabs/stmc.
"""

from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

from mimeline.timeline.clock import MILLISECOND_RATE, milliseconds, seconds
from mimeline.timeline.draft import Draft, DraftInterval, Problem, shown, split_tier, tier_name
from mimeline.timeline.formats.text_file import read_text
from mimeline.timeline.timeline import Timeline

LINE = "ACTION # START # END # TRACK, times in seconds"


def read(path: Path) -> list[Draft]:
    """A draft per timeline of the file."""
    blocks: list[list[tuple[int, str]]] = [[]]
    for number, line in enumerate(read_text(path, "an STMC text file").splitlines(), start=1):
        if line.strip():
            blocks[-1].append((number, line))
        elif blocks[-1]:
            blocks.append([])
    return [_draft(block) for block in blocks if block]


def _draft(lines: list[tuple[int, str]]) -> Draft:
    intervals, problems = [], []
    for number, line in lines:
        try:
            intervals += _intervals(f"line {number}", line)
        except ValueError:
            problems.append(
                Problem(
                    f"line {number}",
                    found=shown(line.strip()),
                    expected=LINE,
                    remedy="Write it so, or take the line out.",
                )
            )
    return Draft(None, tuple(intervals), in_seconds=True, problems=tuple(problems))


def _intervals(place: str, line: str) -> list[DraftInterval]:
    action, start, end, *tiers = (part.strip() for part in line.split("#"))
    times: tuple[Fraction, Fraction] = seconds(start), seconds(end)
    if not tiers:
        return [DraftInterval(place, None, action, *times)]
    parts = [split_tier(tier) for tier in tiers]
    return [DraftInterval(place, track, action, *times, side=side) for track, side in parts]


def write(timelines: Sequence[Timeline]) -> str:
    """The timelines as text. Raises ValueError where milliseconds cannot tell frames apart."""
    return "\n".join(_block(timeline) for timeline in timelines)


def _block(timeline: Timeline) -> str:
    lines = []
    for interval in sorted(timeline, key=lambda interval: interval.start):
        times = (_text(frame, timeline.fps) for frame in (interval.start, interval.end))
        tier = tier_name(interval.track, interval.side)
        lines.append(" # ".join((interval.action, *times, tier)) + "\n")
    return "".join(lines)


def _text(frame: int, fps: Fraction) -> str:
    whole, rest = divmod(milliseconds(frame, fps), MILLISECOND_RATE)
    return f"{whole}.{f'{rest:03d}'.rstrip('0') or '0'}"
