"""The arrays of an npz file, read without unpickling and within limits of size."""

import zipfile
from collections.abc import Collection
from pathlib import Path

import numpy as np

from mimeline.errors import BadFile, unreadable

MOST_ARRAYS, MOST_BYTES = 64, 500_000_000  # of a file; of the arrays that are read, unpacked


def read_arrays(
    path: Path,
    remedy: str,
    names: Collection[str] | None = None,
    most_bytes: int = MOST_BYTES,
) -> dict[str, np.ndarray]:
    """The arrays of an npz file by their names.

    remedy: what the user may do about a file that is refused. names: those to read, where they are
    there (None: every one); others are not unpacked. most_bytes: of those that are read.
    Raises BadFile where it is no npz file, too large, or holds Python objects.
    """
    expected = f"an npz file of at most {MOST_ARRAYS} arrays and {most_bytes // 10**6} MB"
    try:
        sizes = _sizes(path)
        wanted = [name for name in sizes if names is None or name in names]
        n_bytes = sum(sizes[name] for name in wanted)
        if len(sizes) > MOST_ARRAYS or n_bytes > most_bytes:
            found = f"{len(sizes)} arrays, {n_bytes // 10**6} MB of them to read"
            raise BadFile(path, found=found, expected=expected, remedy=remedy)
        with np.load(path, allow_pickle=False) as arrays:
            content = {name: arrays[name] for name in wanted}
        strange = [name for name, value in content.items() if not isinstance(value, np.ndarray)]
        if strange:
            found = f"{strange[0]}, which is no array"
            raise BadFile(path, found=found, expected=expected, remedy=remedy)
        return content
    except BadFile:
        raise
    except Exception as error:  # a damaged archive raises whatever its bytes ask for
        raise unreadable(path, error, expected=expected, remedy=remedy) from error


def array_names(path: Path, remedy: str) -> list[str]:
    """What the arrays of an npz file are called; none is unpacked. Raises BadFile for no such."""
    try:
        return list(_sizes(path))
    except Exception as error:  # as above
        raise unreadable(path, error, expected="an npz file", remedy=remedy) from error


def _sizes(path: Path) -> dict[str, int]:
    """Bytes, unpacked, of each array by its name."""
    with zipfile.ZipFile(path) as archive:
        sizes: dict[str, int] = {}
        for member in archive.infolist():
            name = member.filename.removesuffix(".npy")
            if name in sizes:
                raise ValueError(f"array {name} twice")
            sizes[name] = member.file_size
        return sizes
