"""The arrays of an npz file, read without unpickling and within limits of size."""

import zipfile
from pathlib import Path

import numpy as np

from mimeline.errors import BadFile, unreadable

MAX_ARRAYS, MAX_BYTES = 64, 2_000_000_000  # of all arrays of a file, unpacked


def read_arrays(path: Path) -> dict[str, np.ndarray]:
    """Every array of an npz file by its name.

    Raises BadFile where it is no npz file, too large, or holds Python objects.
    """
    expected = f"an npz file of at most {MAX_ARRAYS} arrays and {MAX_BYTES // 10**6} MB"
    remedy = "Write plain arrays with numpy.savez; docs/face.md names them."
    try:
        with zipfile.ZipFile(path) as archive:
            members = archive.infolist()
        n_bytes = sum(member.file_size for member in members)
        if len(members) > MAX_ARRAYS or n_bytes > MAX_BYTES:
            found = f"{len(members)} arrays of {n_bytes // 10**6} MB"
            raise BadFile(path, found=found, expected=expected, remedy=remedy)
        with np.load(path, allow_pickle=False) as arrays:
            content = {name: arrays[name] for name in arrays.files}
        strange = [name for name, value in content.items() if not isinstance(value, np.ndarray)]
        if strange:
            found = f"{strange[0]}, which is no array"
            raise BadFile(path, found=found, expected=expected, remedy=remedy)
        return content
    except BadFile:
        raise
    except Exception as error:  # a damaged archive raises whatever its bytes ask for
        raise unreadable(path, error, expected=expected, remedy=remedy) from error
