"""Binary glTF as a container: arrays that come back, and files that are none."""

import json

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays_of

from mimeline.errors import BadFile, NoSuchFile
from mimeline.face import gltf
from mimeline.face.glb import Arrays, Glb, write

NUMBERS = arrays_of.arrays(
    st.sampled_from([np.float32, np.uint16, np.uint32, np.uint8]),
    st.one_of(
        st.tuples(st.integers(1, 9)),
        st.tuples(st.integers(1, 9), st.integers(2, 4)),
        st.tuples(st.integers(1, 3), st.just(4), st.just(4)),
    ),
    elements={"allow_nan": False, "allow_infinity": False},
)


@settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None, max_examples=50
)
@given(st.lists(NUMBERS, min_size=1, max_size=4))
def test_arrays_come_back_as_they_were(tmp_path, values):
    arrays = Arrays()
    numbers = [arrays.add(own) for own in values]
    write(tmp_path / "a.glb", {"asset": {"version": "2.0"}}, arrays)
    file = Glb(tmp_path / "a.glb")
    for number, own in zip(numbers, values, strict=True):
        found = file.values(number)
        assert found.shape == own.shape
        np.testing.assert_array_equal(found, own)


@pytest.mark.parametrize("moved", [0, 1, 5, 400])
def test_offsets_of_few_vertices_take_little_room_and_come_back(tmp_path, moved):
    offsets = np.zeros((400, 3), np.float32)
    offsets[:moved] = np.random.default_rng(0).normal(size=(moved, 3))
    arrays = Arrays()
    number = arrays.add_offsets(offsets)
    write(tmp_path / "a.glb", {"asset": {"version": "2.0"}}, arrays)
    np.testing.assert_array_equal(Glb(tmp_path / "a.glb").values(number), offsets)
    assert ("sparse" in arrays.accessors[number]) == (0 < moved < 400)
    if 0 < moved < 10:
        assert len(arrays.binary) < 200


def test_whole_numbers_that_stand_for_shares_are_shares(tmp_path):
    arrays = Arrays()
    number = arrays.add(np.array([0, 51, 255], np.uint8), normalized=True)
    write(tmp_path / "a.glb", {"asset": {"version": "2.0"}}, arrays)
    np.testing.assert_allclose(Glb(tmp_path / "a.glb").values(number), [0, 0.2, 1], atol=1e-7)


def test_a_file_that_fails_leaves_what_was_there(tmp_path):
    (tmp_path / "a.glb").write_bytes(b"mine")
    with pytest.raises(ValueError):
        write(tmp_path / "a.glb", {"asset": float("nan")}, Arrays())
    assert (tmp_path / "a.glb").read_bytes() == b"mine"
    assert [path.name for path in tmp_path.iterdir()] == ["a.glb"]


def glb_of(document: bytes, size: int | None = None, version: int = 2) -> bytes:
    document += b" " * (-len(document) % 4)
    size = 20 + len(document) if size is None else size
    head = b"glTF" + version.to_bytes(4, "little") + size.to_bytes(4, "little")
    return head + len(document).to_bytes(4, "little") + b"JSON" + document


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"", "begins with b''"),
        (b"words", "begins with b'words'"),
        (b"glTF", "begins with b'glTF'"),
        (glb_of(b"{}", version=1), "version 1"),
        (glb_of(b"{}", size=10**6), "of 1000000 bytes"),
        (glb_of(b"{}")[:-6] + b"\xff" * 6, "no JSON"),
        (glb_of(b"[" * 100_000), "no JSON"),
        (glb_of(b"[1]"), "a JSON list"),
        (glb_of(b"\xff\xfe{}"), "no JSON"),
    ],
)
def test_what_is_no_glb_is_one_typed_error(tmp_path, content, told):
    (tmp_path / "bad.glb").write_bytes(content)
    with pytest.raises(BadFile) as caught:
        Glb(tmp_path / "bad.glb")
    assert told in str(caught.value) and "Export it again" in str(caught.value)


def test_a_file_that_is_not_there_is_told_so(tmp_path):
    with pytest.raises(NoSuchFile):
        Glb(tmp_path / "nowhere.glb")


@settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None, max_examples=300
)
@given(st.data())
def test_a_spoilt_file_is_read_or_refused(tmp_path, data):
    content = bytearray(small(tmp_path))
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(content) - 1))
        match data.draw(st.sampled_from(["change", "cut", "double"])):
            case "change":
                content[at] = data.draw(st.integers(0, 255))
            case "cut":
                del content[at : at + data.draw(st.integers(1, 40))]
            case "double":
                content[at:at] = content[at : at + data.draw(st.integers(1, 40))]
        if not content:
            break
    (tmp_path / "spoilt.glb").write_bytes(content)
    try:
        found = gltf.read(tmp_path / "spoilt.glb")
    except BadFile:
        return
    assert np.isfinite(found.times).all() and (np.diff(found.times) > 0).all()
    assert all(
        np.isfinite(own).all() and len(own) == len(found.times) for own in found.weights.values()
    )


def small(folder) -> bytes:
    """A file of one animated morph target and a head that turns."""
    arrays = Arrays()
    positions = arrays.add(np.eye(3, dtype=np.float32), bounds=True)
    offsets = arrays.add_offsets(np.eye(3, dtype=np.float32))
    times = arrays.add(np.float32([0, 0.1, 0.2]), bounds=True)
    weights = arrays.add(np.float32([0, 0.5, 1]))
    turns = arrays.add(np.tile(np.float32([0, 0, 0, 1]), (3, 1)))
    document = {
        "asset": {"version": "2.0", "extras": {"mimeline": {"fps": "10"}}},
        "nodes": [{"mesh": 0, "children": [1]}, {"name": "head"}],
        "meshes": [
            {
                "primitives": [
                    {"attributes": {"POSITION": positions}, "targets": [{"POSITION": offsets}]}
                ],
                "extras": {"targetNames": ["jawOpen"]},
            }
        ],
        "animations": [
            {
                "samplers": [
                    {"input": times, "output": weights},
                    {"input": times, "output": turns},
                ],
                "channels": [
                    {"sampler": 0, "target": {"node": 0, "path": "weights"}},
                    {"sampler": 1, "target": {"node": 1, "path": "rotation"}},
                ],
            }
        ],
    }
    write(folder / "small.glb", json.loads(json.dumps(document)), arrays)
    return (folder / "small.glb").read_bytes()
