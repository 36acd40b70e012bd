import tracemalloc
import zipfile

import numpy as np
import pytest

from mimeline.archives import npz
from mimeline.errors import BadFile


def refusal(path) -> str:
    with pytest.raises(BadFile) as caught:
        npz.read_arrays(path, remedy="Mend it.")
    assert "Mend it." in str(caught.value)
    return str(caught.value)


@pytest.fixture
def path(tmp_path):
    np.savez(tmp_path / "face.npz", neutral=np.ones((4, 3)), names=np.array(["a", "b"]))
    return tmp_path / "face.npz"


def test_every_array_is_read_by_its_name(path):
    arrays = npz.read_arrays(path, "")
    np.testing.assert_array_equal(arrays["neutral"], np.ones((4, 3)))
    assert arrays["names"].tolist() == ["a", "b"]


def test_objects_in_an_npz_are_refused(path):
    np.savez(path, neutral=np.array([{}], dtype=object))
    assert "allow_pickle=False" in refusal(path)


def test_an_npz_larger_than_the_limit_is_not_unpacked(path):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("neutral.npy", bytes(3 * 10**6))
    with pytest.raises(BadFile, match="found 1 arrays, 3 MB of them to read"):
        npz.read_arrays(path, "", most_bytes=10**6)


def test_arrays_that_are_not_wanted_are_not_unpacked(path):
    """Nor do they count: a large one, one that is spoilt and one of objects lie beside."""
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("large.npy", bytes(3 * 10**6))
        archive.writestr("spoilt.npy", b"nothing of the kind")
    tracemalloc.start()
    arrays = npz.read_arrays(path, "", ["neutral", "missing"], most_bytes=10**6)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert list(arrays) == ["neutral"] and most < 10**6
    assert npz.array_names(path, "") == ["neutral", "names", "large", "spoilt"]


def test_an_array_that_is_there_twice_is_refused(path):
    with zipfile.ZipFile(path, "a") as archive, pytest.warns(UserWarning, match="Duplicate"):
        archive.writestr("neutral.npy", b"")
    assert "neutral twice" in refusal(path)


def test_a_file_among_the_arrays_of_an_npz_is_refused(path):
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("README.txt", "mine")
    assert "found README.txt, which is no array" in refusal(path)


def test_a_damaged_npz_is_refused(path):
    raw = bytearray(path.read_bytes())
    raw[200:230] = bytes(30)
    path.write_bytes(raw)
    assert "expected an npz file" in refusal(path)
