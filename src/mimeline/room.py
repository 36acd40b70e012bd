"""A disk that is full, said in words."""

import errno
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mimeline.errors import MimelineError

FULL = (errno.ENOSPC, errno.EDQUOT)


class NoRoom(MimelineError):
    """A disk has no space left."""

    @classmethod
    def of(cls, folder: str | Path, what: str) -> "NoRoom":
        """what: should have been written in the folder."""
        return cls(
            folder,
            found="no space left on its disk",
            expected=f"room for {what}",
            remedy="Free some, then type the same command: what is done stays done.",
        )


@contextmanager
def room(folder: str | Path, what: str) -> Iterator[None]:
    """Raises NoRoom where the block finds the folder's disk full; what: the block writes there."""
    try:
        yield
    except OSError as error:
        if error.errno not in FULL:
            raise
        raise NoRoom.of(folder, what) from error
