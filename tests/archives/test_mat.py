import os
import struct
import tracemalloc
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays_of
from scipy.io import loadmat, savemat

from mimeline.archives.mat import read_arrays, shapes
from mimeline.errors import BadFile, NoSuchFile

TYPES = ("f8", "f4", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8")


@pytest.fixture
def sequence(tmp_path) -> Path:
    path = tmp_path / "sequence.mat"
    savemat(path, {"coeff": np.arange(12, dtype="f4").reshape(3, 4)}, do_compression=True)
    return path


@st.composite
def numbers(draw) -> np.ndarray:
    kind = np.dtype(draw(st.sampled_from(TYPES)))
    shape = draw(arrays_of.array_shapes(min_dims=2, max_dims=3, min_side=0, max_side=5))
    return draw(arrays_of.arrays(kind, shape))


@settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(array=numbers(), packed=st.booleans())
def test_arrays_are_read_as_scipy_reads_them(array, packed, tmp_path):
    path = tmp_path / "any.mat"
    savemat(path, {"other": "text", "array": array}, do_compression=packed)
    found = read_arrays(path, ["array"])["array"]
    wanted = loadmat(path)["array"]
    np.testing.assert_array_equal(found, wanted)
    assert found.dtype == wanted.dtype


def test_numbers_that_cannot_be_packed_are_read(tmp_path):
    path = tmp_path / "random.mat"
    array = np.frombuffer(np.random.default_rng(0).bytes(800_000), "u8").reshape(100, 1000)
    savemat(path, {"x": array}, do_compression=True)
    assert path.stat().st_size > array.nbytes
    np.testing.assert_array_equal(read_arrays(path, ["x"])["x"], array)


def test_only_what_is_named_is_read(tmp_path):
    path = tmp_path / "many.mat"
    savemat(path, {"a": np.eye(2), "text": "words", "cells": np.array([{}], dtype=object)})
    assert list(read_arrays(path, ["a", "missing"])) == ["a"]


def test_objects_of_matlabs_own_are_passed_over(tmp_path):
    """Its strings and tables have a name where arrays have their dimensions."""
    path = tmp_path / "objects.mat"
    body = struct.pack("<IIII", 6, 8, 17, 0) + struct.pack("<II", 1, 8) + b"greeting"
    path.write_bytes(
        header() + struct.pack("<II", 14, len(body)) + body + matrix(np.eye(2), kind=6, stored=9)
    )
    assert list(read_arrays(path, ["x", "greeting"])) == ["x"]


def test_numbers_that_matlab_stores_small_keep_their_type(tmp_path):
    """MATLAB stores doubles that are small whole numbers as bytes."""
    path = tmp_path / "small.mat"
    body = matrix(np.arange(6, dtype="u1").reshape(2, 3), kind=6, stored=2)
    path.write_bytes(header() + body)
    found = read_arrays(path, ["x"])["x"]
    assert found.dtype == "f8"
    np.testing.assert_array_equal(found, np.arange(6.0).reshape(2, 3))


def test_the_other_byte_order_is_read(tmp_path):
    path = tmp_path / "big_endian.mat"
    path.write_bytes(header(">") + matrix(np.eye(3), kind=6, stored=9, order=">"))
    np.testing.assert_array_equal(read_arrays(path, ["x"])["x"], np.eye(3))


@pytest.mark.parametrize(
    ("value", "found"),
    [
        ("text", "no real numbers"),
        ({"field": 1}, "no real numbers"),
        (np.array([1, "two"], dtype=object), "no real numbers"),
        (np.eye(2) * 1j, "no real numbers"),
    ],
)
def test_what_is_no_array_of_numbers_is_refused(tmp_path, value, found):
    path = tmp_path / "strange.mat"
    savemat(path, {"x": value})
    with pytest.raises(BadFile, match=found):
        read_arrays(path, ["x"])


def test_version_7_3_is_named(tmp_path):
    path = tmp_path / "new.mat"
    text = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM"
    path.write_bytes(text.ljust(512, b"\0") + b"\x89HDF\r\n\x1a\n")
    with pytest.raises(BadFile, match=r"7\.3.*-v7"):
        read_arrays(path, ["x"])


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04", b"\0" * 200, b"no matlab at all" * 20])
def test_other_files_are_refused(tmp_path, content):
    path = tmp_path / "other.mat"
    path.write_bytes(content)
    with pytest.raises(BadFile):
        read_arrays(path, ["x"])


def test_what_is_no_file_is_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "pipe.mat")
    for path in (tmp_path, tmp_path / "pipe.mat"):
        with pytest.raises(BadFile):
            read_arrays(path, ["x"])
    with pytest.raises(NoSuchFile):
        read_arrays(tmp_path / "missing.mat", ["x"])


def test_a_bomb_is_not_unpacked(tmp_path):
    """A hundred megabytes packed to a tenth of one, for an array that declares four numbers."""
    path = tmp_path / "bomb.mat"
    bomb = matrix(np.zeros((2, 2)), kind=6, stored=9) + bytes(100_000_000)
    packed = zlib.compress(bomb, 9)
    path.write_bytes(header() + struct.pack("<II", 15, len(packed)) + packed)
    tracemalloc.start()
    with pytest.raises(BadFile):
        read_arrays(path, ["x"])
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 1_000_000


@pytest.mark.parametrize(
    "shape", [(50_000, 50_000), (2**31 - 1,) * 8, (2**31 - 1,) * 200, (-1, 4), (4,), (2, 3)]
)
def test_a_shape_that_the_bytes_do_not_fill_is_refused(tmp_path, shape):
    path = tmp_path / "hollow.mat"
    path.write_bytes(header() + matrix(np.zeros((2, 2)), kind=6, stored=9, shape=shape))
    with pytest.raises(BadFile, match="variable x"):
        read_arrays(path, ["x"])


def test_arrays_beyond_the_limit_are_refused_by_their_head(tmp_path, sequence):
    with pytest.raises(BadFile, match="variable coeff of 96 bytes"):
        read_arrays(sequence, ["coeff"], most_bytes=90)


def test_an_array_that_is_stored_as_doubles_counts_as_such(tmp_path):
    """As bytes it would be within the limit, which is what it unpacks to that matters."""
    path = tmp_path / "widened.mat"
    body = matrix(np.zeros((1000, 1000)), kind=9, stored=9)
    packed = zlib.compress(body, 9)
    path.write_bytes(header() + struct.pack("<II", 15, len(packed)) + packed)
    tracemalloc.start()
    with pytest.raises(BadFile, match="variable x of 8e\\+06 bytes"):
        read_arrays(path, ["x"], most_bytes=1_000_000)
    assert shapes(path, ["x", "missing"]) == {"x": (1000, 1000)}
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 1_000_000


def test_a_file_of_countless_variables_is_left(tmp_path):
    path = tmp_path / "countless.mat"
    path.write_bytes(header() + struct.pack("<II", 1, 0) * 100_000)
    with pytest.raises(BadFile, match="more than 4096 variables"):
        read_arrays(path, ["x"])


@settings(
    max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(data=st.data())
def test_spoilt_bytes_give_our_error_or_an_array(data, sequence, tmp_path):
    content = bytearray(sequence.read_bytes())
    if data.draw(st.booleans()):  # unpacked: so that the spoilt bytes are those of the matrix
        packed = bytes(content[136:])
        content[128:] = zlib.decompress(packed)
    for place in data.draw(st.lists(st.integers(100, len(content) - 1), min_size=1, max_size=4)):
        content[place] = data.draw(st.integers(0, 255))
    end = data.draw(st.integers(0, len(content)))
    path = tmp_path / "spoilt.mat"
    path.write_bytes(content[: end if data.draw(st.booleans()) else None])
    try:
        found = read_arrays(path, ["coeff"])
    except BadFile as error:
        assert "\n" not in str(error)
    else:
        assert all(array.nbytes < 1000 for array in found.values())


def header(order: str = "<") -> bytes:
    mark = {"<": b"IM", ">": b"MI"}[order]
    return b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack(order + "H", 0x0100) + mark


def matrix(values, kind, stored, order="<", shape=None) -> bytes:
    """A variable x as the format's description has it."""

    def element(number: int, data: bytes) -> bytes:
        return struct.pack(order + "II", number, len(data)) + data + bytes(-len(data) % 8)

    shape = values.shape if shape is None else shape
    flags = element(6, struct.pack(order + "II", kind, 0))
    axes = element(5, struct.pack(f"{order}{len(shape)}i", *shape))
    raw = values.astype(values.dtype.newbyteorder(order)).tobytes(order="F")
    body = flags + axes + element(1, b"x") + element(stored, raw)
    return struct.pack(order + "II", 14, len(body)) + body
