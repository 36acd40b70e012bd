import numpy as np
import pytest

from mimeline.ticc.windows import BLOCK, Products, centred, describe, trailing


@pytest.mark.parametrize("window", [1, 2, 5])
def test_a_window_is_described_by_its_frames_and_its_sums_of_products(window):
    n, size = 3, 20
    values = np.random.default_rng(0).normal(size=(n, size + window - 1))
    products = Products.every(window, n)
    rows = describe(values, window, products)
    assert len(rows) == 1 + window * n + n * (n + 1) // 2 + (window - 1) * n * n
    for s in range(size):
        seen = values[:, s : s + window]  # (n, w)
        assert rows[0, s] == 1
        assert np.array_equal(rows[1 : 1 + window * n, s], seen.T.ravel())
        sums = [
            (seen[i, : window - lag] * seen[j, lag:]).sum()
            for lag, i, j in zip(products.lag, products.first, products.second, strict=True)
        ]
        assert np.allclose(rows[1 + window * n :, s], sums)


def test_only_the_products_that_are_held_are_asked_for():
    held = np.zeros((3, 2, 2), dtype=bool)
    held[0] = np.eye(2)
    held[2, 1, 0] = True
    products = Products.of(held)
    asked = zip(products.lag, products.first, products.second, strict=True)
    assert [tuple(map(int, which)) for which in asked] == [(0, 0, 0), (0, 1, 1), (2, 1, 0)]


@pytest.mark.parametrize("reach", [centred(4), centred(5), trailing(4), centred(1)])
def test_windows_are_cut_where_they_would_reach_over_a_border(reach, windows_of):
    lengths = [1, 9, 3, 4, 2]
    windows = windows_of(np.zeros((19, 1)), lengths, reach.window, reach)
    found = dict(zip(windows.cut.tolist(), windows.lacks[windows.kind].tolist(), strict=True))
    begin = 0
    for length in lengths:
        for t in range(begin, begin + length):
            front = max(reach.before - (t - begin), 0)
            back = max(reach.after - (begin + length - 1 - t), 0)
            assert found.get(t, [0, 0]) == [front, back]
        begin += length


def test_blocks_cover_every_frame_once_and_their_values_are_those_of_the_windows(windows_of):
    X = np.random.default_rng(0).normal(size=(2 * BLOCK + 5, 2))
    windows = windows_of(X, [len(X)], 5)
    blocks = list(windows.blocks())
    assert [blocks[0][0], *(end for _, end in blocks)] == [0, BLOCK, 2 * BLOCK, len(X)]
    padded = np.pad(X, ((2, 2), (0, 0)))
    for begin, end in blocks:
        assert np.array_equal(windows.values(begin, end).T, padded[begin : end + 4])


def test_blocks_are_shorter_where_a_window_has_many_products(windows_of):
    assert (
        max(end - begin for begin, end in windows_of(np.zeros((3000, 40)), [3000], 10).blocks())
        < 100
    )
