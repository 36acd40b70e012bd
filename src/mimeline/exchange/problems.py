"""What is wrong with files of timelines, for people and for programs."""

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from mimeline.errors import BadFile, printable
from mimeline.exchange.reading import Reading, require_file
from mimeline.inspection.layout import GREEN, RED, YELLOW, painter
from mimeline.reporting import words
from mimeline.timeline import files
from mimeline.timeline.draft import Problem

CODES = {"error": RED, "warning": YELLOW}


def lint(paths: Sequence[Path], reading: Reading, shortest: int) -> dict[Path, list[Problem]]:
    """The problems of each file, errors first; an empty list where there are none.

    reading: what is said of the files. shortest: frames; an interval of fewer is warned of. A file
    that cannot be read at all has one problem, which says so.
    """
    return {path: _problems(path, reading, shortest) for path in paths}


def _problems(path: Path, reading: Reading, shortest: int) -> list[Problem]:
    try:
        require_file(path)
        return files.lint(path, reading.fps, reading.n_frames, reading.format, shortest)
    except BadFile as error:
        return [Problem(error.place, error.found, error.expected, error.remedy)]


def errors(found: dict[Path, list[Problem]]) -> int:
    """How many of the problems are errors."""
    return sum(problem.severity == "error" for own in found.values() for problem in own)


def as_text(found: dict[Path, list[Problem]], colour: bool = False) -> str:
    """A line for each problem, and one for the sum. colour: ANSI is welcome."""
    paint = painter(colour)
    lines = [
        f"{printable(str(path))}: {paint(problem.severity, CODES[problem.severity])}: {problem}"
        for path, own in found.items()
        for problem in own
    ]
    n_errors, n_problems = errors(found), sum(map(len, found.values()))
    wrong = words.plural(n_errors, "error"), words.plural(n_problems - n_errors, "warning")
    told = ", ".join(wrong) if n_problems else paint("nothing wrong", GREEN)
    return "\n".join([*lines, f"{told} in {words.plural(len(found), 'file')}"]) + "\n"


def as_json(found: dict[Path, list[Problem]]) -> str:
    """What a program reads: a record for each problem."""
    rows = [{"file": str(path)} | asdict(p) for path, own in found.items() for p in own]
    return json.dumps(rows, indent=1, ensure_ascii=False) + "\n"
