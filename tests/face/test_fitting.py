import numpy as np
import pytest

from mimeline.face.fitting import Unfit, fitted, names_of, vertex_numbers


@pytest.mark.parametrize("kind", ["u1", "i8", "u8", ">i4", "f2", "f8", "g"])
def test_numbers_of_any_type_are_taken_where_none_is_lost(kind):
    value = np.array([[0, 1, 2], [3, 4, 100]], kind)
    for dtype in (np.uint8, np.int32, np.int64, np.float32):
        found = fitted("f", value, dtype, (None, 3))
        assert found.dtype == dtype and found.flags.c_contiguous
        np.testing.assert_array_equal(found, value)


@pytest.mark.parametrize(
    ("value", "dtype"),
    [
        (2**31, np.int32),
        (2.0**31, np.int32),
        (-1, np.uint8),
        (np.uint64(2**63), np.int64),
        (2.0**63, np.int64),
        (1e7, np.float32),
        (-1e300, np.float32),
    ],
)
def test_numbers_that_are_too_large_are_refused(value, dtype):
    with pytest.raises(Unfit, match="found numbers from"):
        fitted("f", np.array([value]), dtype, (1,))


@pytest.mark.parametrize("value", [["a"], [b"a"], [1j], [True], [None], [np.datetime64(0, "s")]])
def test_what_is_no_number_is_refused(value):
    with pytest.raises(Unfit, match="array f: found type .*, expected numbers"):
        fitted("f", value, np.float32, (1,))


def test_another_shape_is_refused_with_both():
    with pytest.raises(Unfit, match=r"found shape \(2, 2\), expected \(any, 3\)"):
        fitted("f", np.zeros((2, 2)), np.float32, (None, 3))
    with pytest.raises(Unfit, match=r"found shape \(\), expected \(4,\)"):
        fitted("f", 1.0, np.float32, (4,))


def test_no_numbers_at_all_are_no_mistake():
    assert vertex_numbers("f", np.zeros((0, 3)), np.int32, (None, 3), 5).shape == (0, 3)
    assert names_of("names", np.array([], np.str_), 0) == []
