"""A disk that is full, said in words."""

import errno
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mimeline.errors import MimelineError

AGAIN = "Free some, then type the same command: the training goes on from its last save."
FULL = (errno.ENOSPC, errno.EDQUOT)


class NoRoom(MimelineError):
    """A disk has no space left."""


@contextmanager
def room(folder: str | Path, what: str, remedy: str) -> Iterator[None]:
    """Raises NoRoom where the block finds the folder's disk full; what: the block writes there."""
    try:
        yield
    except OSError as error:
        if error.errno not in FULL:
            raise
        raise NoRoom(
            folder,
            found="no space left on its disk",
            expected=f"room for {what}",
            remedy=remedy,
        ) from error
