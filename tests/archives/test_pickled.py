"""Pickles of arrays are read without pickle; all else refuses the file, and nothing is run."""

import contextlib
import pickle
from collections import OrderedDict

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csc_matrix

from mimeline.archives.opcodes import MAX_OPCODES, unpickle
from mimeline.archives.pickled import NAMES, plain, read_pickled
from mimeline.errors import BadFile

ARRAYS = {
    "rows": np.arange(6, dtype=np.float32).reshape(2, 3),
    "columns": np.asfortranarray(np.arange(6.0).reshape(2, 3)),
    "turned": np.arange(6, dtype=np.int16).reshape(2, 3).T,
    "big endian": np.arange(3, dtype=">f8"),
    "flags": np.array([True, False]),
    "none": np.zeros((0, 3)),
    "one": np.array(3.5),
    "scalar": np.float32(2.5),
    "bytes": np.array([b"ab", b"c"]),
}
HARM = "import pathlib; pathlib.Path('harmed').touch()"


def content_of(raw: bytes):
    return plain(unpickle(raw, NAMES)[0])


def refusal(tmp_path, raw: bytes) -> str:
    """Why a pickle is refused, in little time, with nothing run or written."""
    (tmp_path / "face.pkl").write_bytes(raw)
    with pytest.raises(BadFile) as caught:
        read_pickled(tmp_path / "face.pkl")
    assert [path.name for path in tmp_path.iterdir()] == ["face.pkl"]
    return str(caught.value)


@pytest.fixture(autouse=True)
def _in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("numpy", ["numpy._core", "numpy.core"])
@pytest.mark.parametrize("protocol", range(6))
def test_arrays_are_read_as_pickle_reads_them(protocol, numpy):
    raw = pickle.dumps(ARRAYS | {"deep": {"text": "é", "n": -3, "x": 0.5}}, protocol=protocol)
    if protocol < 4:  # later ones tell how long the name is
        raw = raw.replace(b"numpy._core", numpy.encode())
    found = content_of(raw)
    assert found.pop("deep") == {"text": "é", "n": -3, "x": 0.5}
    assert list(found) == list(ARRAYS)
    for name, values in ARRAYS.items():
        assert found[name].dtype == values.dtype, name
        np.testing.assert_array_equal(found[name], values, err_msg=name)


def test_arrays_cannot_be_written_to():
    assert not content_of(pickle.dumps(ARRAYS))["rows"].flags.writeable


@pytest.mark.parametrize("protocol", range(5))
def test_a_sparse_matrix_becomes_dense(protocol):
    dense = np.random.default_rng(0).integers(0, 2, (5, 40)) * 0.5
    found = content_of(pickle.dumps({"J": csc_matrix(dense)}, protocol=protocol))
    np.testing.assert_array_equal(found["J"], dense)


def test_a_sparse_matrix_may_count_its_rows_in_numpy():
    matrix = csc_matrix(np.eye(2))
    matrix.__dict__["_shape"] = (np.int64(2), np.int64(2))
    np.testing.assert_array_equal(content_of(pickle.dumps({"J": matrix}))["J"], np.eye(2))


def test_what_is_no_array_text_or_number_becomes_none():
    found = content_of(pickle.dumps({"list": [1], "tuple": (1,), "none": None, "yes": True}))
    assert found == {"list": None, "tuple": None, "none": None, "yes": True}


class Hostile:
    def __reduce__(self):
        return exec, (HARM,)


class Built:
    def __reduce__(self):
        return Built, (), {"x": Hostile()}


@pytest.mark.parametrize("protocol", range(6))
@pytest.mark.parametrize("value", [Hostile(), [({"a": Hostile()},)], Built(), OrderedDict(a=1)])
def test_an_object_is_refused_before_anything_runs(tmp_path, value, protocol):
    message = refusal(tmp_path, pickle.dumps({"f": value}, protocol=protocol))
    assert "found the name " in message


@pytest.mark.parametrize(
    ("raw", "message"),
    [
        (b"\x80\x02cposix\nsystem\n.", "the name posix.system"),
        (b"\x80\x02cos\x1b[31m\nsystem\n.", r"the name os\x1b[31m.system"),
        (b"\x80\x04\x8c\x08builtins\x8c\x04eval\x93.", "the name builtins.eval"),
        (b"\x80\x02cnumpy\nload\n.", "the name numpy.load"),
        (b"\x80\x02c__builtin__\nobject\n(tR.", "a pickle that calls what is no name"),
        (b"\x80\x02c_codecs\nencode\n}(X\x01\x00\x00\x00aK\x01ub.", "a state for what has none"),
        (b"\x80\x02cchumpy.ch\nCh\n}(X\x01\x00\x00\x00aK\x01ub.", "a state for what has none"),
        (b"\x80\x02}}(X\x01\x00\x00\x00aK\x01ub.", "a state for what has none"),
        (b"(S'id'\nios\nsystem\n.", "opcode 'i'"),
        (b"(cos\nsystem\nS'id'\no.", "the name os.system"),
        (b"(]S'id'\no.", "opcode 'o'"),
        (b"\x80\x04])}\x92.", r"opcode '\x92'"),  # NEWOBJ_EX
        (b"\x80\x02\x82\x01.", r"opcode '\x82'"),  # EXT1
        (b"\x80\x02\x84\x01\x00\x00\x00.", r"opcode '\x84'"),  # EXT4
        (b"\x80\x05\x97.", r"opcode '\x97'"),  # NEXT_BUFFER
        (b"\x80\x02]2\x86.", "opcode '2'"),  # DUP
        (b"\x80\x02\x8b\x04\x00\x00\x00\x00\x00\x00\x80.", r"opcode '\x8b'"),  # LONG4
        (b"\x80\x02]r\xff\xff\xff\x7f.", "found a list"),  # a memo of two thousand million places
        (b"\x80\x02]q\x05h\x06.", "breaks off or is garbled"),
        (b"\x80\x02}(X\x01\x00\x00\x00acchumpy.ch\nCh\n)\x81u.", "an array without content"),
        (b"\x80\x02}(X\x01\x00\x00\x00aK\x01K\x02u.", "breaks off or is garbled"),
        (b"\x80\x02}(]K\x01u.", "keys that are no names"),
        (b"\x80\x02Pname\n.", "a persistent id"),
        (b"\x80\x02K\x01Q.", "a persistent id"),
        (b"\x80\x04\x8e" + b"\xff" * 7 + b"\x7f.", "breaks off"),  # BINBYTES8
        (b"\x80\x05\x96" + b"\xff" * 8 + b".", "breaks off"),
        (b"\x80\x02T\xff\xff\xff\xff.", "breaks off"),  # a text of -1 bytes
        (b"\x80\x02}", "breaks off"),
        (b"\x80\x02.", "breaks off"),
        (b"", "breaks off"),
        (b"<!DOCTYPE html>\n", "opcode '<'"),
        (b"N" * (MAX_OPCODES + 1) + b".", f"more than {MAX_OPCODES} opcodes"),
    ],
)
def test_what_data_does_not_need_is_refused(tmp_path, raw, message):
    assert message in refusal(tmp_path, raw)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ((b"K\x06\x85", b"J\xff\xff\xff\x7f\x85"), "an array with a strange shape"),
        ((b"K\x06\x85", b"J\xff\xff\xff\xff\x85"), "an array with a strange shape"),
        ((b"K\x06\x85", b"\x8a\x06\x00\x10\xa5\xd4\xe8\x00\x85"), "an array with a strange shape"),
        ((b"K\x06\x85", b"K\x07\x85"), "more or less than it holds"),
        ((b"K\x06\x85", b"K\x05\x85"), "more or less than it holds"),
        ((b"K\x06\x85", b"N"), "an array with a strange shape"),
        ((b"i8", b"O8"), "an array of O8"),
        ((b"i8", b"V8"), "an array of V8"),
        ((b"i8", b"M8"), "an array of M8"),
        ((b"X\x02\x00\x00\x00i8", b"X\x05\x00\x00\x00i4,f4"), "an array of i4,f4"),
        ((b"X\x02\x00\x00\x00i8", b"X\x06\x00\x00\x00(9,)i8"), "an array of (9,)i8"),
        ((b"NNNJ", b"NX\x01\x00\x00\x00aNJ"), "an array of records"),
    ],
)
def test_an_array_that_is_not_what_it_claims_is_refused(tmp_path, change, message):
    raw = pickle.dumps({"f": np.arange(6, dtype=np.int64)}, protocol=2)
    assert change[0] in raw
    assert message in refusal(tmp_path, raw.replace(*change))


def test_an_array_of_objects_is_refused(tmp_path):
    objects = np.array([{}, Hostile()])
    assert "an array of O8" in refusal(tmp_path, pickle.dumps({"f": objects}, protocol=2))


@pytest.mark.parametrize(
    "change",
    [
        {"indices": np.array([0, 9], np.int32)},
        {"indices": np.array([0, -1], np.int32)},
        {"indptr": np.array([0, 1, 2**31 - 1], np.int32)},
        {"indptr": np.array([0, 5, 2], np.int32)},
        {"indptr": np.array([0, 2], np.int32)},
        {"data": np.ones(3)},
        {"_shape": (10**6, 10**6)},
        {"_shape": (0, 10**9)},
        {"_shape": (2, 2, 2)},
    ],
)
def test_a_sparse_matrix_that_is_garbled_is_refused(tmp_path, change):
    matrix = csc_matrix(np.eye(2))
    matrix.__dict__.update(change)
    refusal(tmp_path, pickle.dumps({"J": matrix}))


MEGABYTE = b"B\x00\x00\x10\x00" + b"x" * 2**20 + b"q\x00"
MEGATEXT = b"X\x00\x00\x10\x00" + b"x" * 2**20 + b"q\x00"
LONG_TUPLE = b"(" + b"N" * 50_000 + b"tq\x00"


@pytest.mark.parametrize(
    "raw",
    [
        b"}]" + b"\x85" * 90_000 + b"K\x01s.",  # a deep tuple as a key
        b"]" + b"\x85" * 90_000 + b".",
        b"]" * 40_000 + b"a" * 39_999 + b".",
        b"}K\x01" * 40_000 + b"N" + b"s" * 40_000 + b".",
        b")q\x00" + b"h\x00h\x00\x86q\x00" * 20_000 + b".",  # each twice the one before
        b")q\x00" + b"h\x00h\x00\x86q\x00" * 90 + b"cnumpy\ndtype\nh\x00\x85R.",
        b"]q\x00" + b"h\x00a" * 30_000 + b".",  # a list of itself
        MEGATEXT + b"c_codecs\nencode\nh\x00\x85R" * 9_000 + b".",
        MEGATEXT + b"h\x00h\x00\x93" * 9_000 + b".",
        MEGABYTE + b"}(" + b"h\x00N" * 9_000 + b"u.",
        MEGABYTE + b"cnumpy\ndtype\nh\x00\x85R" * 9_000 + b".",
        LONG_TUPLE + b"cnumpy\ndtype\nh\x00R" * 9_000 + b".",
    ],
    ids=range(12),
)
def test_a_pickle_that_would_swell_is_refused(tmp_path, raw):
    """It would take hours, or all of the memory."""
    refusal(tmp_path, b"\x80\x02" + raw)


def test_a_long_text_in_many_places_is_left_out():
    entries = b"".join(b"M" + n.to_bytes(2, "little") + b"h\x00" for n in range(9_000))
    found = content_of(MEGABYTE + b"}(" + entries + b"u.")
    assert set(found.values()) == {None}


def test_dictionaries_in_each_other_are_not_unfolded(tmp_path):
    doubled = b"}q\x00" + b"".join(
        b"}(X\x01\x00\x00\x00ah\x00X\x01\x00\x00\x00bh\x00uq\x00" for _ in range(60)
    )
    assert "deeper than" in refusal(tmp_path, b"\x80\x02" + doubled + b"h\x00.")
    wide = b"}q\x00(" + b"".join(b"X\x04\x00\x00\x00%04dN" % n for n in range(200)) + b"u"
    wide += b"}(" + b"".join(b"X\x04\x00\x00\x00%04dh\x00" % n for n in range(200)) + b"u."
    assert "more than 10000 entries" in refusal(tmp_path, b"\x80\x02" + wide)


GOOD = pickle.dumps(ARRAYS | {"J": csc_matrix(np.eye(3)), "deep": {"x": 1.5}}, protocol=2)


@given(data=st.data())
def test_a_spoilt_pickle_is_read_or_refused(tmp_path_factory, data):
    path = tmp_path_factory.getbasetemp() / "spoilt.pkl"
    raw = bytearray(GOOD)
    for _ in range(data.draw(st.integers(1, 8))):
        place = data.draw(st.integers(0, len(raw) - 1))
        raw[place : place + data.draw(st.integers(0, 3))] = data.draw(st.binary(max_size=4))
    path.write_bytes(raw)
    with contextlib.suppress(BadFile):
        assert isinstance(read_pickled(path), dict)


def test_several_pickles_in_a_row_are_read_one_by_one():
    raw = pickle.dumps({"a": 1}) + pickle.dumps({"b": 2})
    first, end = unpickle(raw, NAMES)
    second, end = unpickle(raw, NAMES, start=end)
    assert (first, second, end) == ({"a": 1}, {"b": 2}, len(raw))


def test_a_pickle_of_python_2_has_text_as_bytes():
    assert content_of(b"(dS'it\\'s'\nS'\\xe9'\ns.") == {"it's": "é"}
    assert content_of(b"\x80\x02}U\x01aT\x01\x00\x00\x00\xe9s.") == {"a": "é"}


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(BadFile, match="no such file"):
        read_pickled(tmp_path / "none.pkl")
