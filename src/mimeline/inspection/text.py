"""An inspection as text for people, aligned and at most 100 columns wide, and as JSON."""

import json
import math
import re

from mimeline.errors import printable
from mimeline.inspection.inspection import Inspection, Range
from mimeline.inspection.layout import BOLD, FAINT, RED, YELLOW, listed, painter, table, wrapped

NAME, NUMBER, COURSE, GAP = 19, 6, 10, "  "  # of a channel's cell
LEVELS, DEAD = "▁▂▃▄▅▆▇█", "·"
LEGEND = (
    "over time: the peaks of coefficients, from 0 to 1; angles from their lowest to their highest"
)
NARROWEST = 0.1  # radians: an angle that moves less is drawn low, not stretched over all levels


def as_text(seen: Inspection, colour: bool = False) -> str:
    """What a person reads; an error is left to standard error. colour: ANSI codes are welcome."""

    paint = painter(colour)
    lines = [f"{paint(printable(str(seen.path)), BOLD)}: {seen.kind}", *listed(seen.facts, paint)]
    if seen.rows:
        lines += ["", *table(seen.rows)]
    if seen.ranges:
        lines += ["", paint(_head(), FAINT), *_cells(seen.ranges), paint(f"  {LEGEND}", FAINT)]
    for title, texts, code in (("notes", seen.notes, YELLOW), ("problems", seen.problems, RED)):
        lines += ["", paint(title, code)] if texts else []
        for text in texts:
            first, *more = wrapped(text, 4)
            lines += [f"  - {first}", *(f"    {line}" for line in more)]
    return "\n".join(lines) + "\n"


def as_json(seen: Inspection) -> str:
    """What a program reads: numbers are plain, angles radians."""
    held = {"path": str(seen.path), "kind": seen.kind} | seen.numbers
    if seen.ranges:
        held["ranges"] = {r.channel: [r.low, r.mean, r.high] for r in seen.ranges}
    held |= {"notes": seen.notes, "problems": [*filter(None, [seen.error]), *seen.problems]}
    return json.dumps(held, indent=1, ensure_ascii=False) + "\n"


def _head() -> str:
    numbers = "".join(name.rjust(NUMBER) for name in ("low", "mean", "high"))
    cell = f"{'channel':<{NAME}}{numbers}  {'over time':<{COURSE}}"
    return f"{cell}{GAP}{cell}".rstrip()


def _cells(ranges: list[Range]) -> list[str]:
    """Two channels to a line: left and right beside each other, then the others as they come."""
    found = {r.channel: r for r in ranges}
    pairs, single = [], []
    for name in found:
        right = name.removesuffix("Left") + "Right"
        if name.endswith("Left") and right in found:
            pairs.append((found[name], found[right]))
        elif not (name.endswith("Right") and name.removesuffix("Right") + "Left" in found):
            single.append(found[name])
    pairs += [tuple(single[n : n + 2]) for n in range(0, len(single), 2)]
    return [GAP.join(map(_cell, pair)).rstrip() for pair in pairs]


def _cell(r: Range) -> str:
    texts = [f"{math.degrees(v):.0f}°" if r.angle else f"{v:.2f}" for v in (r.low, r.mean, r.high)]
    texts = [re.sub("^-(?=[0.°]*$)", "", text) for text in texts]  # no -0
    return f"{r.channel:<{NAME}}{''.join(t.rjust(NUMBER) for t in texts)}  {_course(r):<{COURSE}}"


def _course(r: Range) -> str:
    """A column of blocks for each stretch of time, a space where the channel was not measured."""
    if r.dead:
        return DEAD * len(r.course)
    low, high = (r.low, max(r.high, r.low + NARROWEST)) if r.angle else (0.0, 1.0)
    top = len(LEVELS) - 1
    levels = [None if v is None else round(top * (v - low) / (high - low)) for v in r.course]
    return "".join(" " if n is None else LEVELS[min(max(n, 0), top)] for n in levels)
