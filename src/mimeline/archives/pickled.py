"""Arrays out of a pickle file of which nothing is run.

Every name that a pickle may mention has a stand-in here; any other name refuses the whole file. So
neither numpy's own unpickling nor the code of scipy, chumpy or torch is reached.
"""

import math
import re
from pathlib import Path
from typing import Any

import numpy as np

from mimeline.archives.opcodes import Known, Refused, Standin, unpickle
from mimeline.errors import BadFile, unreadable

MAX_BYTES = 1_000_000_000  # of a file, and of the arrays that are made from it
MAX_SPARSE = 100_000_000  # bytes of a sparse matrix, made dense
MAX_ENTRIES, MAX_DEPTH, MAX_AXES = 10_000, 4, 8  # of the dictionaries; of an array
LONGEST_TEXT = 1_000
PLAIN_TYPES = re.compile(r"[<>=|]?(b1|[iu][1248]|f[248]|S[0-9]{1,4})")  # numbers and short bytes


def read_pickled(path: Path) -> dict:
    """The dictionary of a pickle file that holds numpy, scipy CSC and chumpy arrays; as arrays.

    Raises BadFile for any other content, before any of it is made.
    """
    remedy = "Give the model file as it is published, or save its arrays with numpy.savez."
    expected = "a dictionary of numpy, scipy.sparse CSC and chumpy arrays"
    try:
        if path.stat().st_size > MAX_BYTES:
            found, limit = f"{path.stat().st_size // 10**6} MB", f"at most {MAX_BYTES // 10**6} MB"
            raise BadFile(path, found=found, expected=limit, remedy=remedy)
        content, _ = unpickle(path.read_bytes(), NAMES)
        return plain(content)
    except BadFile:
        raise
    except Refused as error:
        raise BadFile(path, found=str(error), expected=expected, remedy=remedy) from error
    except Exception as error:  # a broken pickle raises whatever its bytes ask for
        raise unreadable(path, error, expected=expected, remedy=remedy) from error


def plain(content: Any) -> dict:
    """What was unpickled, as a dictionary of arrays, text, numbers, None and such dictionaries.

    Lists, tuples and all else become None, and so does Python 2's text of more than LONGEST_TEXT.
    Arrays are read-only views of the pickle.
    Raises Refused where it is no dictionary, or too deep, or too much.
    """
    if type(content) is not dict:
        raise Refused(f"a {type(content).__name__}")
    return _Unwrapping().of(content, MAX_DEPTH)


class _Unwrapping:
    """A walk through dictionaries; what is met twice counts twice."""

    def __init__(self):
        self.entries, self.bytes = 0, 0

    def of(self, content: dict, depth: int) -> dict:
        self.entries += len(content)
        if not depth or self.entries > MAX_ENTRIES:
            raise Refused(f"more than {MAX_ENTRIES} entries, or deeper than {MAX_DEPTH}")
        return {str(name): self.value(value, depth - 1) for name, value in content.items()}

    def value(self, value, depth: int):
        if isinstance(value, Array):
            values = value.values()
            self.bytes += values.nbytes
            if self.bytes > MAX_BYTES:
                raise Refused(f"arrays of more than {MAX_BYTES // 10**6} MB")
            return values
        if isinstance(value, dict):
            return self.of(value, depth)
        if isinstance(value, bytes):
            return value.decode("latin1") if len(value) <= LONGEST_TEXT else None
        return value if isinstance(value, str | int | float) else None


class _DType(Standin):
    """numpy.dtype: a code, and the byte order that its state gives."""

    def __init__(self, code, *_):
        code = _text(code)
        if not PLAIN_TYPES.fullmatch(code):
            raise Refused(f"an array of {code[:20]}")
        self.dtype = np.dtype(code)

    def fill(self, state):
        if any(part is not None for part in state[2:5]):  # a subarray, names, fields
            raise Refused("an array of records")
        if (order := _text(state[1])) in ("<", ">"):
            self.dtype = self.dtype.newbyteorder(order)


class Array(Standin):
    """numpy.ndarray: a view of the pickle's bytes."""

    def __init__(self, values: np.ndarray | None = None):
        self._values = values

    def fill(self, state):
        _, shape, kind, fortran, raw = state
        self._values = _view(raw, kind, shape, "F" if fortran else "C")

    def values(self) -> np.ndarray:
        if self._values is None:
            raise Refused("an array without content")
        return self._values


class _Csc(Array):
    """scipy.sparse.csc_matrix, as a dense array."""

    def fill(self, state):
        parts = (_array(state[name]) for name in ("data", "indices", "indptr"))
        self.data, self.rows, self.starts = parts
        shape = state.get("_shape", state.get("shape"))[:MAX_AXES]
        self.shape = _shape(tuple(int(_array(n)) if isinstance(n, Array) else n for n in shape))
        size = math.prod(self.shape)
        if len(self.shape) != 2 or 8 * size > MAX_SPARSE or not len(self.data) <= size > 0:
            raise Refused("a sparse matrix that is too large, or holds more than its size")
        if self.data.shape != self.rows.shape or self.starts.shape != (self.shape[1] + 1,):
            raise Refused("a sparse matrix that is garbled")

    def values(self):
        counts = np.diff(self.starts.astype(np.int64))  # (columns,)
        known = self.starts[0] == 0 and self.starts[-1] == len(self.data) and (counts >= 0).all()
        if not known or (self.rows < 0).any():
            raise Refused("a sparse matrix that is garbled")
        columns = np.repeat(np.arange(self.shape[1]), counts)  # (n,)
        dense = np.zeros(self.shape)
        np.add.at(dense, (self.rows, columns), self.data)
        return dense


class _Chumpy(Array):
    """chumpy.ch.Ch, as the array that it wraps."""

    def fill(self, state):
        self._values = _array(state["x"])


class _Kind(Known):
    """The class of an array."""


def _view(raw, kind, shape, order="C") -> np.ndarray:
    """The array in bytes, where shape and type claim just as many as there are."""
    dtype, shape = _of(_DType, kind).dtype, _shape(shape)
    if type(raw) is not bytes or dtype.itemsize * math.prod(shape) != len(raw):
        raise Refused("an array that claims more or less than it holds")
    return np.frombuffer(raw, dtype).reshape(shape, order=order)


def _shape(shape) -> tuple[int, ...]:
    if type(shape) is not tuple or len(shape) > MAX_AXES:
        raise Refused("an array with a strange shape")
    for n in shape:
        if type(n) is not int or not 0 <= n <= MAX_BYTES:
            raise Refused("an array with a strange shape")
    return shape


def _array(value) -> np.ndarray:
    if type(value) is not Array:
        raise Refused("an array without its parts")
    return value.values()


def _of(kind: type, value):
    if not isinstance(value, kind):
        raise Refused("an array without its parts")
    return value


def _text(value) -> str:
    if not isinstance(value, str | bytes) or len(value) > LONGEST_TEXT:
        raise Refused("an array of a strange type")
    return value.decode("latin1") if isinstance(value, bytes) else value


def _reconstruct(kind, *_):
    return _of(_Kind, kind).make()


def _scalar(kind, raw=b""):
    return Array(_view(raw, kind, ()))


def _from_buffer(raw, kind, shape, order):
    return Array(_view(raw, kind, shape, "F" if _text(order) == "F" else "C"))


def _encode(text, _encoding="latin1"):
    return _of(str, text).encode("latin1")


def _nothing(*_):
    return None


ARRAYS: dict[str, Any] = {  # what NumPy's own pickles name
    "numpy.ndarray": _Kind(lambda *_: Array()),
    "numpy.dtype": Known(_DType),
    "copy_reg._reconstructor": Known(_reconstruct),
    "copyreg._reconstructor": Known(_reconstruct),
    "__builtin__.bytes": Known(lambda: b""),  # how protocol 2 writes no bytes at all
    "builtins.bytes": Known(lambda: b""),
    "_codecs.encode": Known(_encode),
}
for _core in ("numpy.core", "numpy._core"):
    ARRAYS |= {
        f"{_core}.multiarray._reconstruct": Known(_reconstruct),
        f"{_core}.multiarray.scalar": Known(_scalar),
        f"{_core}.numeric._frombuffer": Known(_from_buffer),
    }
NAMES = ARRAYS | {  # and what face models are of
    "scipy.sparse.csc.csc_matrix": _Kind(lambda *_: _Csc()),
    "scipy.sparse._csc.csc_matrix": _Kind(lambda *_: _Csc()),
    "chumpy.ch.Ch": _Kind(lambda *_: _Chumpy()),
    "__builtin__.object": None,
    "builtins.object": None,
    "__builtin__.set": Known(_nothing),
    "builtins.set": Known(_nothing),
}
