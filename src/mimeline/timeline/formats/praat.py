"""Praat's TextGrid as text: an interval tier per track, empty intervals where it is neutral.

The long form is written; long and short are read alike, as Praat does: of all that stands there
only numbers, texts in quotes and flags in angle brackets count. Source: Praat manual, "TextGrid
file formats".
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

from mimeline.errors import BadFile
from mimeline.timeline.clock import seconds
from mimeline.timeline.draft import (
    Draft,
    DraftInterval,
    Problem,
    ignored,
    is_foreign,
    shown,
    split_tier,
    tier_name,
)
from mimeline.timeline.formats.text_file import read_bytes, read_text
from mimeline.timeline.timeline import SIDES, Interval, Timeline
from mimeline.vocabulary import TRACKS

SAVE_AS_TEXT = "In Praat: Save, Save as text file."

_TOKEN = re.compile(
    r"""
    "(?P<text>(?:[^"]|"")*+)"
    | (?P<open>")
    | <(?P<flag>[a-z]+)>
    | \[[^\[\]\n]*\]
    | ![^\n]*
    | (?P<number>[+-]?[0-9.][0-9.eE+-]*)(?=\s|$)
    | [^\s"\[]+
    | \[
    """,
    re.VERBOSE,
)


@dataclass(frozen=True)
class _Token:
    kind: str
    value: str
    line: int


def read(path: Path) -> list[Draft]:
    """The one draft that the file holds; its length is told in seconds."""
    if read_bytes(path, "a TextGrid").startswith(b"ooBinaryFile"):
        raise BadFile(
            path, found="a binary TextGrid", expected="a TextGrid as text", remedy=SAVE_AS_TEXT
        )
    tokens = _Tokens(path, _tokens(read_text(path, "a TextGrid")))
    if (form := tokens.take("text")) not in ("ooTextFile", "ooTextFile short"):
        raise tokens.wrong(shown(form), 'File type = "ooTextFile"')
    if (kind := tokens.take("text")) != "TextGrid":
        raise tokens.wrong(f"an object of {shown(kind)}", 'Object class = "TextGrid"')
    start, end = tokens.seconds(), tokens.seconds()
    if start != 0:
        raise tokens.wrong(
            f"a start at {float(start)} s",
            "0",
            "In Praat: Modify, Shift to zero.",
        )
    reader = _Reader()
    if tokens.take("flag") == "exists":
        for _ in range(tokens.count()):
            reader.read_tier(tokens)
    return [
        Draft(
            None,
            tuple(reader.intervals),
            in_seconds=True,
            seconds=end,
            tracks=tuple(reader.tracks),
            problems=tuple(reader.problems),
        )
    ]


def _tokens(text: str) -> Iterator[_Token]:
    line, seen = 1, 0
    for match in _TOKEN.finditer(text):
        line += text.count("\n", seen, match.start())
        seen = match.start()
        if match.lastgroup is not None:
            yield _Token(match.lastgroup, match[match.lastgroup], line)


class _Tokens:
    """What counts in the file, one after the other; anything unexpected is an error."""

    def __init__(self, path: Path, tokens: Iterator[_Token]):
        self.path, self.tokens, self.line = path, tokens, 1

    def take(self, kind: str) -> str:
        token = next(self.tokens, None)
        if token is None:
            raise self.wrong("the end of the file", f"a {kind}")
        self.line = token.line
        if token.kind == "open":
            raise self.wrong("a text whose closing quote lacks", "its end")
        if token.kind != kind:
            raise self.wrong(f"{token.kind} {shown(token.value)}", f"a {kind}")
        return token.value.replace('""', '"') if kind == "text" else token.value

    def seconds(self) -> Fraction:
        number = self.take("number")
        try:
            return seconds(number)
        except ValueError as error:
            raise self.wrong(shown(number), "a time in seconds") from error

    def count(self) -> int:
        number = self.take("number")
        if not re.fullmatch(r"[0-9]{1,9}", number):
            raise self.wrong(shown(number), "how many follow")
        return int(number)

    def wrong(self, found: str, expected: str, remedy: str = "") -> BadFile:
        remedy = remedy or f"See that the file is whole and opens in Praat. {SAVE_AS_TEXT}"
        place = f"line {self.line}"
        return BadFile(self.path, place=place, found=found, expected=expected, remedy=remedy)


@dataclass
class _Reader:
    """Collects intervals, measured tracks and problems, tier by tier."""

    intervals: list[DraftInterval] = field(default_factory=list)
    tracks: dict[str, None] = field(default_factory=dict)  # in order
    problems: list[Problem] = field(default_factory=list)

    def read_tier(self, tokens: _Tokens) -> None:
        kind, name = tokens.take("text"), tokens.take("text")
        if kind not in ("IntervalTier", "TextTier"):
            raise tokens.wrong(f"a tier of {shown(kind)}", "an IntervalTier")
        tokens.seconds(), tokens.seconds()
        line, found = tokens.line, []
        for _ in range(tokens.count()):
            start = tokens.seconds()
            end = start if kind == "TextTier" else tokens.seconds()
            text = tokens.take("text").strip()
            found.append((f"line {tokens.line}, tier {name}", text, start, end))
        values = tuple(text for _, text, _, _ in found if text)
        if is_foreign(name, values):
            self.problems += [ignored(f"tier {shown(name)}", len(values))] if values else []
        elif kind == "TextTier":
            self.problems.append(
                Problem(
                    f"line {line}, tier {name}",
                    found="a point tier",
                    expected="an interval tier: an action lasts",
                    remedy="In Praat, make an interval tier of it, or remove it.",
                )
            )
        else:
            self._add(name, found)

    def _add(self, name: str, found: list[tuple[str, str, Fraction, Fraction]]) -> None:
        track, side = split_tier(name)
        self.tracks[track] = None
        for place, text, start, end in found:
            if text:
                self.intervals.append(DraftInterval(place, track, text, start, end, side=side))


def write(timelines: Sequence[Timeline]) -> str:
    """The timeline in the long text form, times with all digits of a double.

    Raises ValueError for a clip without frames, which no TextGrid can be.
    """
    (timeline,) = timelines
    if timeline.n_frames == 0:
        raise ValueError("a clip without frames, which no TextGrid can be")
    end = _text(timeline.n_frames, timeline.fps)
    tiers = list(_tiers(timeline))
    lines = [
        'File type = "ooTextFile"',
        'Object class = "TextGrid"',
        "",
        "xmin = 0 ",
        f"xmax = {end} ",
        "tiers? <exists> ",
        f"size = {len(tiers)} ",
        "item []: ",
    ]
    for number, (name, intervals) in enumerate(tiers, start=1):
        filled = list(_filled(intervals, timeline.n_frames))
        lines += [
            f"    item [{number}]:",
            '        class = "IntervalTier" ',
            f'        name = "{name}" ',
            "        xmin = 0 ",
            f"        xmax = {end} ",
            f"        intervals: size = {len(filled)} ",
        ]
        for count, (start, stop, action) in enumerate(filled, start=1):
            lines += [
                f"        intervals [{count}]:",
                f"            xmin = {_text(start, timeline.fps)} ",
                f"            xmax = {_text(stop, timeline.fps)} ",
                f'            text = "{action}" ',
            ]
    return "\n".join(lines) + "\n"


def _tiers(timeline: Timeline) -> Iterator[tuple[str, list[Interval]]]:
    """A tier per measured track, and one per side that it uses."""
    for track in (t for t in TRACKS if t in timeline.tracks):
        for side in (None, *SIDES):
            found = [i for i in timeline.tracks[track] if i.side == side]
            if found or side is None:
                yield tier_name(track, side), found


def _filled(intervals: Sequence[Interval], n_frames: int) -> Iterator[tuple[int, int, str]]:
    """Start, end and action, with empty ones between them."""
    reached = 0
    for interval in intervals:
        if interval.start > reached:
            yield reached, interval.start, ""
        yield interval.start, interval.end, interval.action
        reached = interval.end
    if reached < n_frames:
        yield reached, n_frames, ""


def _text(frame: int, fps: Fraction) -> str:
    time = float(frame / fps)
    return str(int(time)) if time.is_integer() else repr(time)
