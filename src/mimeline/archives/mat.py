"""Arrays of numbers in MATLAB's .mat files of version 5 to 7, read within limits of size.

A file is a row of elements, each with its type and size before it, and most of them deflated. Only
arrays that are asked for are unpacked, and none beyond what its head declares: a library that
unpacks whatever the bytes ask for would fill the memory of whoever opens a hostile file.
Source: MathWorks, "MAT-File Format" (R2024a), chapter 1.
"""

import struct
import sys
import zlib
from collections.abc import Callable, Collection
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import BinaryIO

import numpy as np

from mimeline.errors import BadFile, unreadable

MOST_VARIABLES, MOST_AXES = 4096, 8
HEAD = 4096  # bytes that hold flags, dimensions and name of a variable
MATRIX, COMPRESSED = 14, 15
NUMBERS = {
    1: "i1",
    2: "u1",
    3: "i2",
    4: "u2",
    5: "i4",
    6: "u4",
    7: "f4",
    9: "f8",
    12: "i8",
    13: "u8",
}  # how an element's bytes are to be read
CLASSES = {
    6: "f8",
    7: "f4",
    8: "i1",
    9: "u1",
    10: "i2",
    11: "u2",
    12: "i4",
    13: "u4",
    14: "i8",
    15: "u8",
}  # what MATLAB holds them as
OPAQUE, COMPLEX = 17, 0x08


class _Spoilt(Exception):
    """What is wrong with a file, in words."""


@dataclass(frozen=True)
class _Head:
    name: str
    kind: int
    is_complex: bool
    shape: tuple[int, ...]
    end: int  # where the numbers' element begins


def read_arrays(
    path: Path, names: Collection[str], most_bytes: int = 2_000_000_000
) -> dict[str, np.ndarray]:
    """The arrays of numbers that bear one of these names, as MATLAB shapes them (two axes or more).

    names: of variables; one that the file lacks is absent from the answer. most_bytes: of all of
    them as doubles, which any may be stored as. Raises BadFile for what is no .mat file of version
    5 to 7, too large or spoilt, and where a named variable is no array of real numbers.
    """
    return _read(path, names, most_bytes, _array)


def shapes(path: Path, names: Collection[str]) -> dict[str, tuple[int, ...]]:
    """What the arrays of these names claim to be, by their heads: nothing else is unpacked.

    Raises BadFile as `read_arrays` does, but for what stands behind the heads.
    """
    return _read(path, names, sys.maxsize, None)


def _read(path: Path, names: Collection[str], most_bytes: int, unpack: Callable | None) -> dict:
    limit = f" with arrays of at most {most_bytes / 1e6:g} MB" if unpack else ""
    expected = f"a .mat file of version 5 to 7{limit}"
    remedy = "Save it again, in MATLAB with -v7, in Python with scipy.io.savemat."
    try:
        if Path(path).exists() and not Path(path).is_file():
            raise _Spoilt("no file")
        with open(path, "rb") as file:
            return _variables(file, set(names), most_bytes, unpack)
    except _Spoilt as problem:
        raise BadFile(path, found=str(problem), expected=expected, remedy=remedy) from None
    except (struct.error, zlib.error) as error:
        found = "a file that breaks off, or spoilt bytes"
        raise BadFile(path, found=found, expected=expected, remedy=remedy) from error
    except (OSError, ValueError, MemoryError) as error:
        raise unreadable(path, error, expected=expected, remedy=remedy) from error


def _variables(file: BinaryIO, names: set[str], left: int, unpack: Callable | None) -> dict:
    order = _byte_order(file.read(128))
    found = {}
    for _ in range(MOST_VARIABLES):
        tag = file.read(8)
        if not tag:
            return found
        if len(tag) < 8:
            raise _Spoilt("a file that breaks off")
        kind, size = struct.unpack(order + "II", tag)
        start = file.tell()
        if kind in (MATRIX, COMPRESSED):
            inflate = kind == COMPRESSED
            body = _body(file.read(min(size, HEAD)), HEAD, order, inflate)
            head = _head(body, order)
            if head.name in names:
                if head.name in found:
                    raise _Spoilt(f"variable {head.name} twice")
                room = _room(head, left)
                if unpack is None:
                    found[head.name] = head.shape
                    file.seek(start + size)
                    continue
                file.seek(start)
                if size > room + room // 100:  # deflating what is random adds a little
                    raise _Spoilt(f"variable {head.name} with more bytes than its shape has")
                packed = file.read(size)
                if len(packed) < size:
                    raise _Spoilt("a file that breaks off")
                found[head.name] = unpack(_body(packed, room, order, inflate), head, order)
                left -= room
        file.seek(start + size)
    raise _Spoilt(f"more than {MOST_VARIABLES} variables")


def _byte_order(header: bytes) -> str:
    """struct's sign for the byte order that a file's first 128 bytes tell."""
    if header.startswith(b"\x89HDF") or header.startswith(b"MATLAB 7.3"):
        raise _Spoilt("version 7.3, which is an HDF5 file")
    marks = {b"IM": "<", b"MI": ">"}
    if len(header) < 128 or (order := marks.get(header[126:])) is None:
        raise _Spoilt("no .mat header")
    (version,) = struct.unpack(order + "H", header[124:126])
    if version != 0x0100:
        raise _Spoilt(f"version {version >> 8}.{version & 255}")
    return order


def _body(data: bytes, most: int, order: str, inflate: bool) -> memoryview:
    """A matrix' elements, of a deflated one no more than so many bytes."""
    if not inflate:
        return memoryview(data)
    data = zlib.decompressobj().decompress(data, most + 8)
    kind, _ = struct.unpack_from(order + "II", data)
    if kind != MATRIX:
        raise _Spoilt(f"a compressed element of type {kind}")
    return memoryview(data)[8:]


def _element(data: memoryview, start: int, order: str) -> tuple[int, int, int, int]:
    """Type, begin and end of the element at start, and where the next one begins."""
    first, size = struct.unpack_from(order + "II", data, start)
    if first >> 16:  # a small one: the size beside the type, the data in the tag
        kind, size, begin = first & 0xFFFF, first >> 16, start + 4
        if size > 4:
            raise _Spoilt(f"a small element of {size} bytes")
        return kind, begin, begin + size, start + 8
    begin = start + 8
    return first, begin, begin + size, begin + -(-size // 8) * 8


def _head(body: memoryview, order: str) -> _Head:
    _, flags_begin, _, flags_end = _element(body, 0, order)
    (flags,) = struct.unpack_from(order + "I", body, flags_begin)
    if flags & 255 == OPAQUE:  # an object of MATLAB's own, which has no dimensions
        return _Head("", OPAQUE, False, (), flags_end)
    kind, begin, end, shape_end = _element(body, flags_end, order)
    if kind != 5 or end > len(body) or (end - begin) % 4:
        raise _Spoilt("a variable without dimensions")
    shape = struct.unpack_from(f"{order}{(end - begin) // 4}i", body, begin)
    _, begin, end, name_end = _element(body, shape_end, order)
    if end > len(body):
        raise _Spoilt("a variable with a very long name")
    name = bytes(body[begin:end]).decode("latin-1")
    return _Head(name, flags & 255, bool(flags >> 8 & COMPLEX), shape, name_end)


def _room(head: _Head, left: int) -> int:
    """Bytes that a variable's elements may take. Raises where it is no array that may be read."""
    if head.kind not in CLASSES or head.is_complex:
        raise _Spoilt(f"variable {head.name}, which holds no real numbers")
    if not 2 <= len(head.shape) <= MOST_AXES or min(head.shape) < 0:
        raise _Spoilt(f"variable {head.name} of shape {head.shape[: MOST_AXES + 1]}")
    n_bytes = 8 * prod(head.shape)  # stored as doubles at most
    if n_bytes > left:
        raise _Spoilt(f"variable {head.name} of {n_bytes:.3g} bytes")
    return head.end + n_bytes + 64  # padded


def _array(body: memoryview, head: _Head, order: str) -> np.ndarray:
    kind, begin, end, _ = _element(body, head.end, order)
    if kind not in NUMBERS:
        raise _Spoilt(f"variable {head.name} of type {kind}")
    stored = np.dtype(NUMBERS[kind]).newbyteorder(order)
    count = prod(head.shape)
    if end - begin != count * stored.itemsize or end > len(body):
        raise _Spoilt(f"variable {head.name} with fewer or more numbers than its shape has")
    numbers = np.frombuffer(body, stored, count, begin)
    return numbers.astype(CLASSES[head.kind]).reshape(head.shape, order="F")
