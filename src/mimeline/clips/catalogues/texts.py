"""CelebV-Text's descriptions: folders with a text file per clip, a sentence on each line."""

import logging
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from pathlib import Path

from mimeline.clips.catalogues.annotations import match
from mimeline.clips.failure import spelt_out
from mimeline.errors import BadFile, unreadable

log = logging.getLogger(__name__)

ENDING = ".txt"
MOST_BYTES = 1 << 16  # of a file
MOST_LINES = 100  # of a file; each clip has twenty in all
REMEDY = "Check catalogue.celebvtext.texts."


def read_texts(
    data: Path, folders: Iterable[str], names: Sequence[str], starts: Sequence[float]
) -> list[list[str]]:
    """For each clip the lines of its files, <name>.txt, in the folders, in their order.

    folders: under data. names (n,), starts (n,): as `match` takes them, which finds the files of
    names that do not quite fit. What is no Unicode or cannot be printed is spelt out.
    Raises BadFile where a folder has no such file, or one cannot be read.
    """
    texts: list[list[str]] = [[] for _ in names]
    same: dict[str, str] = {}  # sentences repeat over clips
    for folder in folders:
        files = _files(data / folder)
        found, _ = match(names, starts, files)
        log.info("%s: texts of %d of %d clips", folder, len(found) - found.count(None), len(names))
        for lines, key in zip(texts, found, strict=True):
            if key is not None:
                lines += (same.setdefault(line, line) for line in _lines(files[key]))
    return texts


def _files(place: Path) -> dict[str, Path]:
    """Name without ending → text file."""
    expected = "a folder with <clip>.txt"
    try:
        files = {p.name.removesuffix(ENDING): p for p in place.iterdir() if p.suffix == ENDING}
    except OSError as error:
        raise unreadable(place, error, expected=expected, remedy=REMEDY) from error
    if not files:
        raise BadFile(place, found="no text file", expected=expected, remedy=REMEDY)
    return files


def _lines(path: Path) -> Iterator[str]:
    try:
        with path.open("rb") as file:
            raw = file.read(MOST_BYTES)
    except OSError as error:
        raise unreadable(path, error, expected="a text file", remedy=REMEDY) from error
    lines = (
        " ".join(line.split()) for line in raw.decode("utf-8", "backslashreplace").splitlines()
    )
    return islice(map(spelt_out, filter(None, lines)), MOST_LINES)
