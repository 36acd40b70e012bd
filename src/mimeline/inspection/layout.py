"""Text for people: at most 100 columns wide, aligned, with colour where it is welcome."""

import re
import textwrap
from collections.abc import Callable, Mapping, Sequence

from mimeline.errors import printable

WIDTH = 100
BOLD, FAINT, RED, GREEN, YELLOW = "1", "2", "31", "32", "33"
WORDS = re.compile(r"(?<!\()\b[A-Za-z]{2,}")  # what stands in brackets beside a number is none

Paint = Callable[[str, str], str]


def painter(colour: bool) -> Paint:
    """Puts ANSI codes around a text, where colour is welcome."""
    return lambda text, code: f"\x1b[{code}m{text}\x1b[0m" if colour else text


def wrapped(text: str, indent: int) -> list[str]:
    """Lines of at most WIDTH with the indent; a number stays with the word before it."""
    tied = re.sub(r" (?=\d)", "\N{NO-BREAK SPACE}", printable(text))
    lines = textwrap.wrap(tied, WIDTH - indent, break_on_hyphens=False) or [""]
    return [line.replace("\N{NO-BREAK SPACE}", " ") for line in lines]


def listed(facts: Mapping[str, str], paint: Paint) -> list[str]:
    """Names with their texts beside them, indented."""
    lines, label = [], max(map(len, facts), default=0)
    for name, text in facts.items():
        first, *more = wrapped(text, label + 4)
        lines.append(f"  {paint(name.ljust(label), FAINT)}  {first}")
        lines += [" " * (label + 4) + line for line in more]
    return lines


def table(rows: Sequence[Sequence[str]]) -> list[str]:
    """Rows under their head: names and words to the left, numbers to the right."""
    columns = [list(map(printable, column)) for column in zip(*rows, strict=True)]
    widths = [max(map(len, column)) for column in columns]
    words = [n == 0 or any(map(WORDS.search, column[1:])) for n, column in enumerate(columns)]
    lines = (
        (c.ljust(w) if left else c.rjust(w) for c, w, left in zip(row, widths, words, strict=True))
        for row in zip(*columns, strict=True)
    )
    return [f"  {'  '.join(line)}".rstrip() for line in lines]
