"""Binary glTF 2.0 as a container: a JSON document and the arrays that it speaks of."""

import json
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from mimeline.atomic import whole
from mimeline.errors import BadFile, unreadable

MAGIC, VERSION, JSON, BINARY = b"glTF", 2, b"JSON", b"BIN\0"
HEAD, CHUNK = struct.Struct("<4sII"), struct.Struct("<I4s")
MOST_BYTES = 500_000_000  # of a file; of an accessor's array
REMEDY = "Export it again as binary glTF 2.0 (.glb), all in one file and not compressed."

COMPONENTS = {
    5120: np.dtype("i1"),
    5121: np.dtype("u1"),
    5122: np.dtype("<i2"),
    5123: np.dtype("<u2"),
    5125: np.dtype("<u4"),
    5126: np.dtype("<f4"),
}
CODES = {dtype: code for code, dtype in COMPONENTS.items()}
TYPES = {"SCALAR": (), "VEC2": (2,), "VEC3": (3,), "VEC4": (4,), "MAT4": (4, 4)}
VERTEX_DATA, INDICES = 34962, 34963  # what a view is for
SPARSE_BELOW = 0.75  # of the dense array's bytes: more is not worth another indirection


class Arrays:
    """Arrays for a document: each becomes an accessor, known by its number."""

    def __init__(self):
        self.accessors: list[dict[str, Any]] = []
        self.views: list[dict[str, Any]] = []
        self.binary = bytearray()

    def add(
        self,
        values: np.ndarray,
        target: int | None = None,
        bounds: bool = False,
        normalized: bool = False,
    ) -> int:
        """The accessor of values (n, ...), of a dtype that glTF has.

        target: VERTEX_DATA, INDICES, or None for neither. bounds: tell the least and the greatest,
        which glTF asks of positions and of key times. normalized: whole numbers that stand for 0 to
        1. Matrices are given as numpy has them, row by row.
        """
        values = np.asarray(values)
        accessor = self._accessor(values, bounds)
        accessor |= {"normalized": True} if normalized else {}
        flat = values.transpose(0, 2, 1) if values.ndim == 3 else values  # column by column
        accessor["bufferView"] = self._view(flat, target)
        return self._known(accessor)

    def add_offsets(self, values: np.ndarray) -> int:
        """The accessor of values (n, 3) float32 most of which are 0: only the others are stored."""
        values = np.asarray(values, np.float32)
        moved = np.flatnonzero(values.any(axis=1))
        numbers = moved.astype(np.uint16 if len(values) <= 65_536 else np.uint32)
        stored = numbers.nbytes + values[moved].nbytes
        if not len(moved) or stored >= SPARSE_BELOW * values.nbytes:
            return self.add(values, VERTEX_DATA, bounds=True)
        accessor = self._accessor(values, bounds=True)
        accessor["sparse"] = {
            "count": len(moved),
            "indices": {
                "bufferView": self._view(numbers, None),
                "componentType": CODES[numbers.dtype],
            },
            "values": {"bufferView": self._view(values[moved], None)},
        }
        return self._known(accessor)

    def _accessor(self, values: np.ndarray, bounds: bool) -> dict[str, Any]:
        kind = next(name for name, shape in TYPES.items() if shape == values.shape[1:])
        accessor = {"componentType": CODES[values.dtype], "count": len(values), "type": kind}
        if bounds:
            accessor["min"] = np.atleast_1d(values.min(axis=0)).tolist()
            accessor["max"] = np.atleast_1d(values.max(axis=0)).tolist()
        return accessor

    def _known(self, accessor: dict[str, Any]) -> int:
        self.accessors.append(accessor)
        return len(self.accessors) - 1

    def _view(self, values: np.ndarray, target: int | None) -> int:
        self.binary += b"\0" * (-len(self.binary) % 4)
        content = np.ascontiguousarray(values).tobytes()
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(content)}
        self.views.append(view | ({} if target is None else {"target": target}))
        self.binary += content
        return len(self.views) - 1


def write(path: Path, document: Mapping[str, Any], arrays: Arrays) -> None:
    """Write a document with its arrays; the file is whole or not there."""
    binary = bytes(arrays.binary) + b"\0" * (-len(arrays.binary) % 4)
    document = {
        **document,
        "accessors": arrays.accessors,
        "bufferViews": arrays.views,
        "buffers": [{"byteLength": len(binary)}],
    }
    text = json.dumps(document, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    told = text.encode()
    told += b" " * (-len(told) % 4)
    size = HEAD.size + 2 * CHUNK.size + len(told) + len(binary)
    with whole(path) as temporary, open(temporary, "wb") as file:
        file.write(HEAD.pack(MAGIC, VERSION, size))
        for kind, content in ((JSON, told), (BINARY, binary)):
            file.write(CHUNK.pack(len(content), kind))
            file.write(content)


class Glb:
    """A file that was read: `document`, as its JSON has it, and the arrays of its accessors.

    Nothing outside the file is opened. Raises BadFile where it is no whole binary glTF 2.0; so does
    `values` for an accessor that does not fit its buffer.
    """

    def __init__(self, path: Path):
        self.path = Path(path)
        try:
            size = self.path.stat().st_size
            if size > MOST_BYTES:
                raise self.bad(f"{size // 10**6} MB", f"at most {MOST_BYTES // 10**6} MB")
            content = self.path.read_bytes()
        except OSError as error:
            raise unreadable(
                path, error, expected="a binary glTF file", remedy="See that the path is right."
            ) from error
        self.document, self._binary = self._parsed(content)

    def values(self, number: object) -> np.ndarray:
        """The array (n, ...) of an accessor, whole numbers that stand for 0 to 1 as floats."""
        try:
            return self._values(number)
        except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
            raise self.bad(
                f"accessor {number!r}, which cannot be had ({error!r})", "arrays in the file itself"
            ) from error

    def bad(self, found: str, expected: str, place: str = "") -> BadFile:
        """What is wrong with the file, as an error."""
        return BadFile(self.path, place=place, found=found, expected=expected, remedy=REMEDY)

    def _parsed(self, content: bytes) -> tuple[dict[str, Any], bytes]:
        expected = "binary glTF 2.0"
        if content[:4] != MAGIC or len(content) < HEAD.size + CHUNK.size:
            raise self.bad(f"a file that begins with {content[:16]!r}", expected)
        _, version, size = HEAD.unpack_from(content)
        if version != VERSION:
            raise self.bad(f"version {version}", expected)
        if size > len(content):
            raise self.bad(f"{len(content)} of {size} bytes", "a whole file")
        chunks, at = {}, HEAD.size
        while at + CHUNK.size <= size:
            length, kind = CHUNK.unpack_from(content, at)
            at += CHUNK.size
            if at + length > size:
                raise self.bad(f"a part of {length} bytes in {size - at}", "a whole file")
            chunks.setdefault(kind, content[at : at + length])
            at += length
        try:
            document = json.loads(chunks.get(JSON, b"").decode())
        except (ValueError, RecursionError) as error:
            raise self.bad(f"a document that is no JSON ({error})", expected) from error
        if not isinstance(document, dict):
            raise self.bad(f"a document that is a JSON {type(document).__name__}", expected)
        return document, chunks.get(BINARY, b"")

    def _values(self, number: object) -> np.ndarray:
        if not isinstance(number, int) or number < 0:
            raise LookupError("no number of an accessor")
        accessor = self.document["accessors"][number]
        dtype, shape = COMPONENTS[accessor["componentType"]], TYPES[accessor["type"]]
        count = _whole(accessor["count"])
        if count * dtype.itemsize * int(np.prod(shape, initial=1)) > MOST_BYTES:
            raise ValueError(f"{count} elements")
        if "bufferView" in accessor:
            start = accessor.get("byteOffset", 0)
            values = self._viewed(accessor["bufferView"], start, count, dtype, shape)
        else:
            values = np.zeros((count, *shape), dtype)
        if "sparse" in accessor:
            sparse, values = accessor["sparse"], values.copy()
            told, kind = sparse["indices"], COMPONENTS[sparse["indices"]["componentType"]]
            stored, n = sparse["values"], _whole(sparse["count"])
            at = self._viewed(told["bufferView"], told.get("byteOffset", 0), n, kind, ())
            start = stored.get("byteOffset", 0)
            values[at] = self._viewed(stored["bufferView"], start, n, dtype, shape)
        values = values.transpose(0, 2, 1) if values.ndim == 3 else values
        if accessor.get("normalized") and dtype.kind in "iu":
            return np.maximum(values / np.float32(np.iinfo(dtype).max), -1, dtype=np.float32)
        return values

    def _viewed(
        self, number: int, start: int, count: int, dtype: np.dtype, shape: tuple[int, ...]
    ) -> np.ndarray:
        view = self.document["bufferViews"][_whole(number)]
        if view.get("buffer", 0) != 0 or "uri" in self.document["buffers"][0]:
            raise ValueError("a buffer in another file")
        begin, length = _whole(view.get("byteOffset", 0)), _whole(view["byteLength"])
        if begin + length > len(self._binary):
            raise ValueError("a view beyond the file's end")
        element = dtype.itemsize * int(np.prod(shape, initial=1))
        stride = _whole(view.get("byteStride", element))
        start = _whole(start)
        if stride < element or (start + (count - 1) * stride + element > length and count):
            raise ValueError("an array beyond its view")
        steps = [
            dtype.itemsize * int(np.prod(shape[k + 1 :], initial=1)) for k in range(len(shape))
        ]
        return np.ndarray(
            (count, *shape), dtype, self._binary, begin + start, (stride, *steps)
        ).copy()


def _whole(number: object) -> int:
    if isinstance(number, bool) or not isinstance(number, int) or number < 0:
        raise ValueError(f"{number!r}, no whole number")
    return number
