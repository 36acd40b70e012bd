"""What torch.save writes is read without torch; all else refuses the file, and nothing is run."""

import contextlib
import io
import os
import pickle
import zipfile

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from mimeline.archives import torch_saved
from mimeline.archives.torch_saved import read_saved, write_saved
from mimeline.errors import BadFile, NoSuchFile

CONTENT = {
    "flame": {"exp": np.linspace(-1, 1, 100, dtype=np.float32)[None], "jaw": np.eye(3)[None, :2]},
    "img_size": np.array([512, 512]),
    "frame_id": "00007",
    "global_step": 470,
}
TENSORS = {
    "float": torch.arange(6.0).reshape(2, 3),
    "double": torch.arange(3, dtype=torch.float64),
    "half": torch.tensor([0.5, 2]).half(),
    "long": torch.tensor([[2**40, -1]]),
    "short": torch.tensor([1, 2], dtype=torch.int16),
    "flags": torch.tensor([True, False]),
    "turned": torch.arange(6.0).reshape(2, 3).T,
    "part": torch.arange(10.0)[3:7:2],
    "parameter": torch.nn.Parameter(torch.ones(2)),
    "one": torch.tensor(3.5),
    "none": torch.zeros(0, 3),
}


def same(found, expected) -> bool:
    if isinstance(expected, dict):
        return found.keys() == expected.keys() and all(same(found[k], expected[k]) for k in found)
    if isinstance(expected, np.ndarray):
        return found.dtype == expected.dtype and np.array_equal(found, expected)
    return found == expected


def refusal(path) -> str:
    """Why a file is refused, with nothing run or written."""
    before = sorted(path.parent.rglob("*"))
    with pytest.raises(BadFile) as caught:
        read_saved(path, "Mend it.")
    assert sorted(path.parent.rglob("*")) == before
    assert "Mend it." in str(caught.value)
    return str(caught.value)


@pytest.fixture
def path(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path / "00007.frame"


def zipped(path, members, **options):
    with zipfile.ZipFile(path, "w", **options) as archive:
        for name, data in members:
            archive.writestr(name, data)


@pytest.mark.parametrize("old", [False, True])
def test_arrays_that_torch_saved_are_read(path, old):
    torch.save(CONTENT, path, _use_new_zipfile_serialization=not old)
    assert same(read_saved(path, ""), CONTENT)


@pytest.mark.parametrize("protocol", range(2, 6))
def test_every_protocol_of_pickle_is_read(path, protocol):
    torch.save(CONTENT, path, pickle_protocol=protocol)
    assert same(read_saved(path, ""), CONTENT)


def test_arrays_of_numpy_1_are_read(path):
    raw = pickle.dumps(CONTENT, protocol=2).replace(b"numpy._core", b"numpy.core")
    zipped(path, [("archive/data.pkl", raw), ("archive/version", b"3\n")])
    assert same(read_saved(path, ""), CONTENT)


def test_tensors_are_read_as_arrays(path):
    torch.save({"tensors": TENSORS}, path)
    found = read_saved(path, "")["tensors"]
    assert same(found, {name: tensor.detach().numpy() for name, tensor in TENSORS.items()})


def test_tensors_in_an_old_file_are_refused(path):
    torch.save(TENSORS, path, _use_new_zipfile_serialization=False)
    assert "the name torch._utils._rebuild_tensor_v2" in refusal(path)


def test_tensors_of_a_big_endian_machine_are_turned(path):
    torch.save({"a": torch.tensor([1.0, 2.0])}, path)
    with zipfile.ZipFile(path) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    folder = "00007"
    members[f"{folder}/byteorder"] = b"big"
    members[f"{folder}/data/0"] = np.array([1, 2], ">f4").tobytes()
    zipped(path, members.items())
    assert read_saved(path, "")["a"].tolist() == [1, 2]


def test_what_is_written_is_read_here_and_by_torch(path):
    write_saved(path, CONTENT)
    assert same(read_saved(path, ""), CONTENT)
    assert same(torch.load(path, weights_only=False), CONTENT)
    first = path.read_bytes()
    write_saved(path, CONTENT)
    assert path.read_bytes() == first


class Hostile:
    def __reduce__(self):
        return os.system, ("touch harmed",)


@pytest.mark.parametrize("old", [False, True])
@pytest.mark.parametrize("content", [Hostile(), {"flame": {"exp": Hostile()}}, [Hostile()]])
def test_a_hostile_file_is_refused_before_anything_runs(path, content, old):
    torch.save(content, path, _use_new_zipfile_serialization=not old)
    assert "the name posix.system in a pickle" in refusal(path)


@pytest.mark.parametrize("hostile", [torch.nn.Linear(1, 1), {"x": torch.Size([1])}])
def test_what_torch_itself_saves_but_is_no_array_is_refused(path, hostile):
    torch.save(hostile, path)
    assert "the name torch." in refusal(path)


GOOD = pickle.dumps(CONTENT, protocol=2)


@pytest.mark.parametrize(
    ("members", "message"),
    [
        ([("archive/version", b"3\n")], "without one data.pkl"),
        ([("a/data.pkl", GOOD), ("b/data.pkl", GOOD)], "without one data.pkl"),
        ([("data.pkl", GOOD)], "without one data.pkl"),
        ([("a/data.pkl", GOOD), ("a/../../x", b"x")], "the member 'a/../../x'"),
        ([("a/data.pkl", GOOD), ("../x\x1b[1m", b"x")], r"the member '../x\x1b[1m'"),
        ([("a/data.pkl", b"\x80\x02cposix\nsystem\n.")], "the name posix.system"),
        ([("a/data.pkl", GOOD[:-20])], "breaks off"),
        ([("a/data.pkl", b"")], "breaks off"),
        ([("a/data.pkl", GOOD), *((f"a/data/{n}", b"") for n in range(1000))], "1000 members"),
    ],
)
def test_an_archive_of_anything_else_is_refused(path, members, message):
    zipped(path, members)
    assert message in refusal(path)


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_a_member_twice_is_refused(path):
    zipped(path, [("a/data.pkl", GOOD), ("a/x", b"1"), ("a/x", b"2")])
    assert "a member twice" in refusal(path)


@pytest.mark.parametrize("method", [zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_a_compressed_member_is_not_unpacked(path, method):
    zipped(path, [("a/data.pkl", GOOD), ("a/data/0", bytes(10**7))], compression=method)
    assert "the compressed member 'a/data.pkl'" in refusal(path)


def patched(raw: bytes, offset: int, change: bytes) -> bytes:
    """raw with bytes of its first member's entry in the directory changed."""
    place = raw.index(b"PK\x01\x02") + offset
    return raw[:place] + change + raw[place + len(change) :]


@pytest.mark.parametrize(
    ("offset", "change"),
    [
        (8, b"\x01\x00"),  # encrypted
        (10, b"\x08\x00"),  # compressed
        (16, b"\x00\x00\x00\x00"),  # another checksum
        (20, b"\xff\xff\xff\x7f"),  # as long as 2 GB, packed
        (24, b"\xff\xff\xff\x7f"),  # unpacked
        (42, b"\xff\xff\xff\x7f"),  # begins elsewhere
    ],
)
def test_a_directory_that_lies_is_refused(path, offset, change):
    zipped(path, [("a/data.pkl", GOOD)])
    path.write_bytes(patched(path.read_bytes(), offset, change))
    refusal(path)


def tensor(key="0", kind="FloatStorage", numel=6, offset=0, size=(2, 3), stride=(3, 1)) -> bytes:
    """A pickle of one tensor."""

    def number(n):
        return b"\x8a\x08" + n.to_bytes(8, "little", signed=True)

    def numbers(them):
        return b"(" + b"".join(number(n) for n in them) + b"t"

    text = (b"X%c\x00\x00\x00%s" % (len(t), t.encode()) for t in ("storage", key, "cpu"))
    what, key, where = text
    storage = b"(" + what + f"ctorch\n{kind}\n".encode() + key + where + number(numel) + b"tQ"
    call = b"(" + storage + number(offset) + numbers(size) + numbers(stride) + b"\x89Nt"
    return b"\x80\x02}X\x01\x00\x00\x00actorch._utils\n_rebuild_tensor_v2\n" + call + b"Rs."


@pytest.mark.parametrize(
    "claim",
    [
        {"numel": 7},
        {"numel": 10**12},
        {"key": "1"},
        {"key": "../data.pkl"},
        {"kind": "BFloat16Storage"},
        {"kind": "UntypedStorage"},
        {"offset": 1},
        {"offset": -1},
        {"offset": 2**40},
        {"size": (3, 3)},
        {"size": (10**6, 10**6)},
        {"size": (-1, 3)},
        {"size": (6,)},
        {"stride": (-3, 1)},
        {"stride": (0, 0), "size": (10**6, 10**6)},
        {"stride": (4, 1)},
        {"stride": (2**40, 1)},
        {"size": (1,) * 9, "stride": (1,) * 9},
    ],
    ids=str,
)
def test_a_tensor_that_claims_what_its_storage_does_not_hold_is_refused(path, claim):
    numbers = ("a/data/0", np.arange(6, dtype=np.float32).tobytes())
    zipped(path, [("a/data.pkl", tensor()), numbers])
    assert read_saved(path, "")["a"].tolist() == [[0, 1, 2], [3, 4, 5]]
    zipped(path, [("a/data.pkl", tensor(**claim)), numbers])
    refusal(path)


def test_a_tensor_may_show_a_number_twice_within_its_storage_size(path):
    torch.save({"t": torch.arange(6.0)[:2].expand(3, 2)}, path)
    assert read_saved(path, "")["t"].tolist() == [[0, 1]] * 3
    torch.save({"t": torch.arange(6.0)[:2].expand(4, 2)}, path)
    assert "more than it holds" in refusal(path)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "an empty file"),
        (b"<!DOCTYPE html><html>", "begins with b'<!DOCTYPE html><'"),
        (b"version https://git-lfs.github.com/spec/v1\n", "begins with b'version https://'"),
        (b"PK\x03\x04 and no more", "not a zip file"),
        (b"\x80\x02K\x01.", "found a int"),
    ],
)
def test_a_file_that_torch_did_not_save_is_refused_with_what_it_is(path, content, message):
    path.write_bytes(content)
    assert message in refusal(path)


def test_a_folder_a_pipe_and_a_link_to_nowhere_are_refused(path):
    path.mkdir()
    assert "found a folder" in refusal(path)
    path.rmdir()
    os.mkfifo(path)
    assert "no regular file" in refusal(path)
    path.unlink()
    path.symlink_to("nowhere")
    with pytest.raises(NoSuchFile):
        read_saved(path, "")
    path.unlink()
    path.symlink_to("/dev/zero")
    assert "no regular file" in refusal(path)


def test_a_file_larger_than_the_limit_is_not_read(path, monkeypatch):
    write_saved(path, CONTENT)
    monkeypatch.setattr(torch_saved, "MAX_BYTES", 1000)
    assert "more than" in refusal(path)


def saved(content) -> bytes:
    file = io.BytesIO()
    torch.save(content, file)
    return file.getvalue()


RAW = {"arrays": saved(CONTENT), "tensors": saved({"t": TENSORS})}


@pytest.mark.parametrize("which", RAW)
def test_a_file_cut_anywhere_is_refused(path, which):
    raw = RAW[which]
    for size in range(0, len(raw), 97):
        path.write_bytes(raw[:size])
        with pytest.raises(BadFile):
            read_saved(path, "")


@settings(max_examples=200)
@given(which=st.sampled_from(sorted(RAW)), data=st.data())
def test_a_spoilt_file_is_read_or_refused(tmp_path_factory, which, data):
    """The pickle within is spoilt and packed again, so that no checksum gives it away."""
    path = tmp_path_factory.getbasetemp() / "spoilt.frame"
    with zipfile.ZipFile(io.BytesIO(RAW[which])) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    name = data.draw(st.sampled_from(sorted(members)))
    raw = bytearray(members[name])
    for _ in range(data.draw(st.integers(1, 6))):
        place = data.draw(st.integers(0, len(raw)))
        raw[place : place + data.draw(st.integers(0, 3))] = data.draw(st.binary(max_size=4))
    zipped(path, (members | {name: bytes(raw)}).items())
    if data.draw(st.booleans()):
        outer = bytearray(path.read_bytes())
        outer[data.draw(st.integers(0, len(outer) - 1))] = data.draw(st.integers(0, 255))
        path.write_bytes(outer)
    with contextlib.suppress(BadFile):
        assert isinstance(read_saved(path, ""), dict)
