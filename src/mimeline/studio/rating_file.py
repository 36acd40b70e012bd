"""The CSV of what people answered about pairs: a row per answer, several persons in one file."""

import csv
import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from mimeline.atomic import whole
from mimeline.errors import BadFile, MissingColumn, unreadable
from mimeline.studio.timelines_of_run import KINDS

# Ma et al. 2025, "User Study": two aspects, five points.
QUESTIONS: dict[str, str] = {
    "accurate": "The motions in the clip match the timeline.",
    "natural": "The motions in the clip look natural.",
}
POINTS: dict[int, str] = {
    5: "Strongly agree",
    4: "Agree",
    3: "Don’t know",
    2: "Disagree",
    1: "Strongly disagree",
}
UNSEEN = 0  # in place of a point: there was no picture to judge
VIEWS = ("film", "face")
COLUMNS = (
    "person",
    "pair",
    "kind",
    "clip_id",
    "view",
    "question",
    "answer",
    "seconds",
    "results",
)
EXPECTED = "a CSV of answers, as mimeline rate writes it"
FORMULA = ("=", "+", "-", "@")  # a cell that begins so is computed by a spreadsheet


@dataclass(frozen=True)
class Rating:
    """answer: a point, or UNSEEN. seconds: that the person looked at the pair until then. results:
    the run's fingerprint."""

    person: str
    pair: str
    kind: str
    clip_id: str
    view: str
    question: str
    answer: int
    seconds: float
    results: str

    @property
    def key(self) -> tuple[str, str, str]:
        return self.person, self.pair, self.question


def read_ratings(path: str | Path) -> list[Rating]:
    """The rows in their order; other columns are passed over.

    Raises BadFile, with the line, for what is no such table, has an answer twice, or a pair as two
    different things; MissingColumn.
    """
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            cells = csv.reader(file, strict=True)
            rows = [(cells.line_num, row) for row in cells if any(row)]
    except csv.Error as error:
        raise BadFile(
            path,
            place=f"line {cells.line_num}",
            found=str(error),
            expected=EXPECTED,
            remedy="Close the quotation marks of a cell; write one within it twice.",
        ) from error
    except (OSError, ValueError) as error:
        remedy = "Give a file that mimeline rate wrote, saved as CSV UTF-8 with commas."
        raise unreadable(path, error, expected=EXPECTED, remedy=remedy) from error
    names = rows[0][1] if rows else []
    if missing := [name for name in COLUMNS if name not in names]:
        raise MissingColumn(
            path,
            found=f"columns {', '.join(names)}" if names else "an empty file",
            expected=", ".join(missing),
            remedy="Give a file that mimeline rate wrote, saved with commas.",
        )
    ratings: dict[tuple, Rating] = {}
    shown: dict[str, tuple] = {}  # pair → what it is
    for line, row in rows[1:]:
        if len(row) != len(names):
            raise _bad_line(path, line, f"{len(row)} cells", f"{len(names)}, as in the first line")
        rating = _rating(path, line, dict(zip(names, row, strict=True)))
        if rating.key in ratings:
            found = f"another answer of {rating.person} to {rating.question} of {rating.pair}"
            raise _bad_line(path, line, found, "one")
        what = rating.kind, rating.clip_id, rating.view
        if what != shown.setdefault(rating.pair, what):
            told = [f"pair {rating.pair} as {', '.join(one)}" for one in (what, shown[rating.pair])]
            raise _bad_line(path, line, told[0], f"{told[1]}, as in a line before")
        ratings[rating.key] = rating
    return list(ratings.values())


def write_ratings(path: str | Path, ratings: Iterable[Rating]) -> None:
    """Write the rows in their order; the file is always whole."""
    with whole(path) as temporary, open(temporary, "w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(COLUMNS)
        for rating in ratings:
            row = [getattr(rating, name) for name in COLUMNS]
            table.writerow([_harmless(cell) if isinstance(cell, str) else cell for cell in row])


def _harmless(text: str) -> str:
    """An apostrophe makes text of it, in a spreadsheet."""
    return f"'{text}" if text.startswith((*FORMULA, "'")) else text


def _meant(cell: str) -> str:
    return cell[1:] if cell[:1] == "'" else cell


def _rating(path: str | Path, line: int, cells: dict[str, str]) -> Rating:
    texts = {name: _meant(cells[name]) for name in COLUMNS}
    for name in ("person", "pair", "clip_id", "results"):
        if not texts[name]:
            raise _bad_line(path, line, f"no {name}", "one")
    for name, allowed in (("kind", KINDS), ("view", VIEWS), ("question", tuple(QUESTIONS))):
        if texts[name] not in allowed:
            expected = f"one of {', '.join(allowed)}"
            raise _bad_line(path, line, f"{name} {texts[name]!r}", expected)
    if texts["answer"] not in map(str, (UNSEEN, *POINTS)):
        raise _bad_line(
            path, line, f"answer {texts['answer']!r}", "a number from 1 to 5, or 0 for not seen"
        )
    try:
        seconds = float(texts["seconds"])
    except ValueError:
        seconds = math.nan
    if not (math.isfinite(seconds) and seconds >= 0):
        raise _bad_line(path, line, f"seconds {texts['seconds']!r}", "a number from 0 on")
    return Rating(**texts | {"answer": int(texts["answer"]), "seconds": seconds})


def _bad_line(path: str | Path, line: int, found: str, expected: str) -> BadFile:
    return BadFile(
        path,
        place=f"line {line}",
        found=found,
        expected=expected,
        remedy="Correct the line, or delete it: that answer is then given again.",
    )
