"""Files that a page writes while others may write them too."""

import contextlib
import hashlib
import os
import stat
from collections.abc import Iterable, Iterator
from pathlib import Path

from mimeline.errors import BadFile, unreadable

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None

Stamp = tuple[int, int, int] | None


def stamp(path: Path) -> Stamp:
    """Another one whenever the file is another; None where there is none."""
    try:
        status = path.stat()
    except FileNotFoundError:
        return None
    except OSError as error:
        raise unreadable(path, error, expected="a file", remedy="Give another place.") from error
    if not stat.S_ISREG(status.st_mode):
        found = "a folder" if stat.S_ISDIR(status.st_mode) else "no regular file"
        raise BadFile(path, found=found, expected="a file", remedy="Give another place.")
    return status.st_ino, status.st_size, status.st_mtime_ns


def revision(stamps: Iterable[Stamp]) -> str:
    """A short text for the page to tell by whether one of the files is another."""
    return hashlib.sha256(repr(list(stamps)).encode()).hexdigest()[:16]


@contextlib.contextmanager
def alone(path: Path) -> Iterator[None]:
    """While no other page writes into the file's folder; makes the folder where there is none.

    The folder itself is locked, so that no lock's file is left. Where it cannot be (on Windows and
    some network drives), of two answers written within the same milliseconds the later may win.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise unwritten(path, error) from error
    with contextlib.ExitStack() as held:
        if fcntl is not None:
            with contextlib.suppress(OSError):
                folder = os.open(path.parent, os.O_RDONLY)
                held.callback(os.close, folder)
                fcntl.flock(folder, fcntl.LOCK_EX)
        yield


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
