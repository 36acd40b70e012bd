"""Text files that come from anywhere, read with a limit."""

import codecs
import os
from pathlib import Path

from mimeline.errors import BadFile, unreadable

MOST_BYTES = 64 * 2**20  # hours of all tracks are some megabytes
_MARKS = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)


def read_bytes(path: Path, kind: str, most_bytes: int = MOST_BYTES) -> bytes:
    """What the file holds. kind: what it should be, for the error. Raises BadFile."""
    try:
        with open(path, "rb") as file:
            size = os.fstat(file.fileno()).st_size
            content = b"" if size > most_bytes else file.read(most_bytes + 1)
    except (OSError, ValueError) as error:
        raise unreadable(
            path, error, expected=kind, remedy="See that the path is right."
        ) from error
    if max(size, len(content)) > most_bytes:  # what is no plain file has no size
        raise BadFile(
            path,
            found=f"{max(size, len(content)) / 2**20:.0f} MiB",
            expected=f"{kind} of at most {most_bytes / 2**20:.0f} MiB",
            remedy="See that it is the right file, or split it.",
        )
    return content


def read_text(path: Path, kind: str, most_bytes: int = MOST_BYTES) -> str:
    """The text of a file in UTF-8, or in UTF-16 where it says so by a byte order mark.

    kind: what it should be, for the error. Raises BadFile.
    """
    content = read_bytes(path, kind, most_bytes)
    encoding = "utf-8"
    for mark, marked in _MARKS:
        if content.startswith(mark):
            content, encoding = content.removeprefix(mark), marked
            break
    try:
        text = content.decode(encoding)
    except UnicodeDecodeError as error:
        raise BadFile(
            path,
            place=f"byte {error.start}",
            found=f"bytes that are no {encoding.upper()}",
            expected=f"{kind}, which is text",
            remedy="Save the file as UTF-8.",
        ) from error
    if "\0" in text:
        raise BadFile(
            path,
            found="bytes of zero",
            expected=f"{kind}, which is text",
            remedy="Save the file as UTF-8 text; a binary form is not read.",
        )
    return text
