"""Arrays out of what torch.save wrote, without torch: NumPy arrays and CPU tensors in dictionaries.

Such a file is a zip archive: <name>/data.pkl, a pickle; <name>/data/0 and so on, the numbers of its
tensors; <name>/byteorder. Nothing in it is compressed, so nothing can unpack to more than it is.
Before torch 1.6 it was a row of pickles; those with tensors are not read.
"""

import io
import math
import pickle
import stat
import sys
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from mimeline.archives.opcodes import Known, Refused, unpickle
from mimeline.archives.pickled import ARRAYS, MAX_AXES, Array, plain
from mimeline.atomic import whole
from mimeline.errors import BadFile, unreadable

MAX_BYTES, MAX_MEMBERS = 64_000_000, 1_000
EXPECTED = "what torch.save writes: arrays or tensors in dictionaries"
ZIP, MEMBER, PICKLES = b"PK\x03\x04", b"PK\x01\x02", (b"\x80", b"(d", b"}")
OLD_MAGIC, OLD_PARTS = 0x1950A86A20F9469CFC6C, 3  # number, version and machine, then the content
ENCRYPTED = 1  # a flag of a member
NUMBERS = {
    "Double": "f8",
    "Float": "f4",
    "Half": "f2",
    "Long": "i8",
    "Int": "i4",
    "Short": "i2",
    "Char": "i1",
    "Byte": "u1",
    "Bool": "b1",
}


def read_saved(path: Path, remedy: str) -> dict:
    """The dictionary that a file of torch.save holds: arrays, text, numbers, and dictionaries.

    remedy: what the user may do about a file that is none. Nothing of the file is run, and there is
    no other way of reading it. Raises BadFile for any other content.
    """
    try:
        return plain(_content(_bytes(path)))
    except Refused as error:
        raise BadFile(path, found=str(error), expected=EXPECTED, remedy=remedy) from error
    except Exception as error:  # a damaged archive raises whatever its bytes ask for
        raise unreadable(path, error, expected=EXPECTED, remedy=remedy) from error


def write_saved(path: Path, content: dict) -> None:
    """Write a dictionary of arrays, text, numbers and dictionaries as torch.save does.

    The same content gives the same bytes. Of the product's files this alone holds a pickle: it is
    for made-up takes.
    """
    members = {
        "data.pkl": pickle.dumps(content, protocol=2),
        "byteorder": sys.byteorder.encode(),
        "version": b"3\n",
    }
    with whole(path) as temporary, zipfile.ZipFile(temporary, "w") as archive:
        for name, data in members.items():
            archive.writestr(zipfile.ZipInfo(f"{path.stem}/{name}"), data)


def _bytes(path: Path) -> bytes:
    status = path.stat()
    if not stat.S_ISREG(status.st_mode):
        raise Refused("a folder" if stat.S_ISDIR(status.st_mode) else "no regular file")
    if status.st_size > MAX_BYTES:
        raise Refused(f"{status.st_size // 10**6} MB, more than {MAX_BYTES // 10**6}")
    return path.read_bytes()


def _content(raw: bytes) -> Any:
    if raw.startswith(ZIP):
        return _from_zip(raw)
    if not raw.startswith(PICKLES):
        start = f"a file that begins with {raw[:16]!r}" if raw else "an empty file"
        raise Refused(start)
    content, end = unpickle(raw, ARRAYS)
    if content == OLD_MAGIC:
        for _ in range(OLD_PARTS):
            content, end = unpickle(raw, ARRAYS, start=end)
    return content


def _from_zip(raw: bytes) -> Any:
    if raw.count(MEMBER) > MAX_MEMBERS:
        raise Refused(f"an archive of more than {MAX_MEMBERS} members")
    with zipfile.ZipFile(io.BytesIO(raw)) as archive:
        members = {member.filename: member for member in archive.infolist()}
        pickles = [name for name in members if name.endswith("/data.pkl")]
        if len(pickles) != 1 or len(members) != len(archive.infolist()):
            raise Refused("an archive without one data.pkl, or with a member twice")
        for name, member in members.items():
            if ".." in name.split("/") or member.flag_bits & ENCRYPTED:
                raise Refused(f"the member {name[:80]!r} in an archive")
            if member.compress_type or member.compress_size != member.file_size:
                raise Refused(f"the compressed member {name[:80]!r} in an archive")
        folder = pickles[0].removesuffix("data.pkl")
        content, _ = unpickle(archive.read(pickles[0]), NAMES, _Storages(archive, folder).numbers)
        return content


class _Storages:
    """The numbers of tensors: members of an archive, each read once."""

    def __init__(self, archive: zipfile.ZipFile, folder: str):
        self.archive, self.folder = archive, folder
        self.known: dict[str, bytes] = {}

    def numbers(self, persistent_id: tuple) -> np.ndarray:
        """The numbers (n,) that a persistent id means."""
        what, kind, key, _, size, *_ = persistent_id
        if what != "storage" or not isinstance(kind, np.dtype) or not isinstance(key, str):
            raise Refused("a persistent id that is no storage")
        order = ">" if self._member("byteorder") == b"big" else "<"
        numbers = np.frombuffer(self._member(f"data/{key}"), kind.newbyteorder(order))
        if len(numbers) != size:
            raise Refused("a storage that claims more or less than it holds")
        return numbers

    def _member(self, name: str) -> bytes:
        if name not in self.known:
            there = f"{self.folder}{name}" in self.archive.namelist()
            self.known[name] = self.archive.read(f"{self.folder}{name}") if there else b""
        return self.known[name]


def _tensor(storage, offset, size, stride, *_):
    """torch._utils._rebuild_tensor_v2: a view of a storage, of no more numbers than it has."""
    if not isinstance(storage, np.ndarray):
        raise Refused("a tensor without a storage")
    if len(size) != len(stride) or len(size) > MAX_AXES:
        raise Refused("a tensor with a strange shape")
    if not all(type(n) is int and 0 <= n <= MAX_BYTES for n in (*size, *stride, offset)):
        raise Refused("a tensor with a strange shape")
    last = offset + sum((n - 1) * step for n, step in zip(size, stride, strict=True))
    count = math.prod(size)
    if count > len(storage) or (count and last >= len(storage)):
        raise Refused("a tensor that claims more than it holds")
    bytes_per_step = [step * storage.itemsize for step in stride]
    view = np.lib.stride_tricks.as_strided
    return Array(view(storage[offset:], size, bytes_per_step, writeable=False))


def _parameter(tensor, *_):
    if not isinstance(tensor, Array):
        raise Refused("a parameter without a tensor")
    return tensor


NAMES: dict[str, Any] = ARRAYS | {
    "torch._utils._rebuild_tensor_v2": Known(_tensor),
    "torch._utils._rebuild_parameter": Known(_parameter),
    "collections.OrderedDict": Known(lambda: {}),
}
NAMES |= {f"torch.{name}Storage": np.dtype(code) for name, code in NUMBERS.items()}
