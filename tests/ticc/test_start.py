import numpy as np

from mimeline.ticc.start import excerpt, refill, surroundings


def test_empty_clusters_are_given_the_runs_that_are_explained_worst(windows_of):
    windows = windows_of(np.zeros((130, 1)), [30, 100], 2)
    costs = np.ones(130)
    costs[22:38] = 9.0  # over a border
    costs[90:120] = 5.0
    labels = refill(np.zeros(130, np.int64), costs, windows, [2, 1])
    for k in (1, 2):
        run = np.flatnonzero(labels == k)
        assert len(run) == 20 and np.ptp(run) == 19
        assert (run < 30).all() or (run >= 30).all()
    assert (labels == 2).nonzero()[0][0] in range(90, 101)


def test_surroundings_are_moments_cut_at_the_borders():
    lengths = np.array([4, 7])
    X = np.random.default_rng(0).normal(size=(11, 2))
    found = surroundings(X, lengths, 2)
    for t, (low, high) in {0: (0, 3), 3: (1, 4), 4: (4, 7), 7: (5, 10), 10: (8, 11)}.items():
        assert np.allclose(found[t, :2], X[low:high].mean(axis=0))
        assert np.allclose(found[t, 2:], X[low:high].std(axis=0))


def test_an_excerpt_takes_whole_pieces_of_single_sequences():
    lengths = np.array([50, 7, 120, 30])
    begins, pieces = excerpt(lengths, 5, 80, 40, np.random.default_rng(1))
    assert 80 <= pieces.sum() < 120 and pieces.max() <= 40
    sequence = np.repeat(np.arange(4), lengths)
    parts = [np.arange(b, b + size) for b, size in zip(begins, pieces, strict=True)]
    assert all(len(set(sequence[part])) == 1 for part in parts)
    assert (np.diff(np.concatenate(parts)) > 0).all()
    begins, sizes = excerpt(lengths, 5, 1000, 1000, np.random.default_rng(1))
    assert begins.tolist() == [0, 50, 57, 177] and np.array_equal(sizes, lengths)


def test_pieces_that_hold_no_whole_window_are_drawn_last():
    lengths = np.array([2] * 200 + [300])
    for seed in range(5):
        _, sizes = excerpt(lengths, 5, 100, 100, np.random.default_rng(seed))
        assert sizes.max() == 100
