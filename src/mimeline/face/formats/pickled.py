"""Arrays out of a pickle file of which nothing is run.

Every name that a pickle may mention stands for a small class of this file; any other name refuses
the whole file. So neither numpy's own unpickling nor scipy's or chumpy's code is reached.
"""

import io
import pickle
from pathlib import Path
from typing import ClassVar

import numpy as np

from mimeline.errors import BadFile, unreadable

MAX_BYTES = 1_000_000_000
KINDS = "biufS"  # of numbers and bytes; no objects


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
        content = _Reader(io.BytesIO(path.read_bytes()), encoding="latin1").load()
        if not isinstance(content, dict):
            raise _Refused(f"a {type(content).__name__}")
        return {str(name): _plain(value) for name, value in content.items()}
    except BadFile:
        raise
    except _Refused as error:
        raise BadFile(path, found=str(error), expected=expected, remedy=remedy) from error
    except Exception as error:  # a broken pickle raises whatever its bytes ask for
        raise unreadable(path, error, expected=expected, remedy=remedy) from error


class _Refused(pickle.UnpicklingError):
    pass


class _DType:
    """numpy.dtype: a code, and the byte order that its state gives."""

    def __init__(self, code, *_):
        self.dtype = np.dtype(_text(code))
        if self.dtype.kind not in KINDS:
            raise _Refused(f"an array of {self.dtype}")

    def __setstate__(self, state):
        if _text(state[1]) in "<>":
            self.dtype = self.dtype.newbyteorder(_text(state[1]))


class _Array:
    """numpy.ndarray, from its shape, type and bytes."""

    def __setstate__(self, state):
        _, shape, kind, fortran, raw = state
        if not isinstance(kind, _DType):
            raise _Refused("an array without a plain type")
        raw = raw.encode("latin1") if isinstance(raw, str) else bytes(raw)
        values = np.frombuffer(raw, kind.dtype)
        self.values = values.reshape(shape, order="F" if fortran else "C")


class _Csc:
    """scipy.sparse.csc_matrix, as a dense array."""

    def __setstate__(self, state):
        data, rows, starts = (_plain(state[name]) for name in ("data", "indices", "indptr"))
        n_rows, n_columns = (int(n) for n in state.get("_shape", state.get("shape")))
        if n_rows * n_columns > MAX_BYTES // 8:
            raise _Refused(f"a sparse matrix of {n_rows} x {n_columns}")
        columns = np.repeat(np.arange(n_columns), np.diff(starts))  # (n,)
        self.values = np.zeros((n_rows, n_columns))
        np.add.at(self.values, (rows, columns), data)


class _Chumpy:
    """chumpy.ch.Ch, as the array that it wraps."""

    def __setstate__(self, state):
        self.values = _plain(state["x"])


class _Object:
    """What Python 2 names as the base of the classes above."""


def _array(*_):
    return _Array()


def _rebuilt(kind, *_):
    if kind not in (_Array, _Csc, _Chumpy):
        raise _Refused("an object of no known class")
    return kind()


def _scalar(kind, raw=b""):
    array = _Array()
    array.__setstate__((1, (), kind, False, raw))
    return array


def _encode(text, _encoding="latin1"):
    return text.encode("latin1")


class _Reader(pickle._Unpickler):  # the one in Python: its memo cannot be made to eat the memory
    KNOWN: ClassVar = {
        "numpy.ndarray": _Array,
        "numpy.dtype": _DType,
        "scipy.sparse.csc.csc_matrix": _Csc,
        "scipy.sparse._csc.csc_matrix": _Csc,
        "chumpy.ch.Ch": _Chumpy,
        "copy_reg._reconstructor": _rebuilt,
        "copyreg._reconstructor": _rebuilt,
        "__builtin__.object": _Object,
        "builtins.object": _Object,
        "__builtin__.set": set,
        "builtins.set": set,
        "_codecs.encode": _encode,
    }
    for _core in ("numpy.core.multiarray", "numpy._core.multiarray"):
        KNOWN[f"{_core}._reconstruct"] = _array
        KNOWN[f"{_core}.scalar"] = _scalar

    def find_class(self, module, name):
        try:
            return self.KNOWN[f"{module}.{name}"]
        except KeyError:
            raise _Refused(f"the name {module}.{name} in a pickle") from None

    def persistent_load(self, _):
        raise _Refused("a persistent id in a pickle")

    def load_build(self):
        if not isinstance(self.stack[-2], _DType | _Array | _Csc | _Chumpy):
            raise _Refused("a state for what has none")
        super().load_build()

    dispatch: ClassVar = pickle._Unpickler.dispatch | {pickle.BUILD[0]: load_build}


def _plain(value):
    """The array in a stand-in; text and numbers as they are; anything else as None."""
    if isinstance(value, _Array | _Csc | _Chumpy):
        return value.values
    return value if isinstance(value, str | int | float | np.ndarray) else None


def _text(value) -> str:
    return value.decode("latin1") if isinstance(value, bytes) else str(value)
