"""Files that a page writes while others may write them too."""

import hashlib
from collections.abc import Iterable
from pathlib import Path

from mimeline.errors import BadFile, unreadable

Stamp = tuple[int, int, int] | None


def stamp(path: Path) -> Stamp:
    """Another one whenever the file is another; None where there is none."""
    try:
        status = path.stat()
    except FileNotFoundError:
        return None
    except OSError as error:
        raise unreadable(path, error, expected="a file", remedy="Give another place.") from error
    return status.st_ino, status.st_size, status.st_mtime_ns


def revision(stamps: Iterable[Stamp]) -> str:
    """A short text for the page to tell by whether one of the files is another."""
    return hashlib.sha256(repr(list(stamps)).encode()).hexdigest()[:16]


def unwritten(path: Path, error: OSError) -> BadFile:
    """The complaint about a file that cannot be written now; the page tries again."""
    return BadFile(
        path,
        found=str(error),
        expected="a place to write to",
        remedy="Make room or allow writing there; what you decide is written as soon as it works.",
    )


def is_tidy(line: str, most: int) -> bool:
    """Whether a typed text is one line without stray spaces, of at most so many characters.

    A cell of a table that begins with `=`, `+`, `-` or `@` would be a formula.
    """
    tidy = " ".join(line.split()) == line and line.isprintable()
    return tidy and 0 < len(line) <= most and line[0] not in "=+-@"
