import numpy as np

from mimeline.ticc.start import excerpt, refill, surroundings


def test_empty_clusters_are_given_the_runs_that_are_explained_worst():
    lengths = np.array([30, 100])
    costs = np.ones(130)
    costs[22:38] = 9.0  # over a border
    costs[90:120] = 5.0
    labels = refill(np.zeros(130, np.int64), costs, lengths, [2, 1], window=2)
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
    index, pieces = excerpt(lengths, 80, 40, np.random.default_rng(1))
    assert pieces.sum() == len(index) and 80 <= len(index) < 120
    sequence = np.repeat(np.arange(4), lengths)
    for part in np.split(index, np.cumsum(pieces)[:-1]):
        assert (np.diff(part) == 1).all() and len(set(sequence[part])) == 1
    everything, sizes = excerpt(lengths, 1000, 1000, np.random.default_rng(1))
    assert np.array_equal(everything, np.arange(207)) and np.array_equal(sizes, lengths)
