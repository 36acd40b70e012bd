import numpy as np
import pytest
from scipy.stats import multivariate_normal

from mimeline.ticc import TICC
from mimeline.ticc.selection import (
    along_betas,
    bic,
    log_likelihood,
    log_path,
    n_switches,
    stability,
)

WINDOW = 4


@pytest.fixture(scope="module")
def swings():
    """Three motions that differ in how they swing and not in where they lie: X, lengths, truth."""
    rng = np.random.default_rng(5)
    pull = [0.9 * np.eye(2), -0.7 * np.eye(2), np.array([[0.0, 0.8], [-0.8, 0.0]])]
    lengths = np.array([400, 300, 500, 300])
    truth = np.concatenate([np.arange(length) // 50 % 3 for length in lengths])
    X = np.zeros((len(truth), 2))
    starts = set(np.cumsum(lengths)[:-1])
    for t in range(1, len(X)):
        before = 0 if t in starts else X[t - 1]
        X[t] = pull[truth[t]] @ (before * np.ones(2)) + rng.normal(size=2)
    return X, lengths, truth


def test_the_planted_number_of_clusters_has_the_lowest_bic(plant):
    lengths = [600, 500, 600]
    X, _ = plant(lengths, seed=2)
    found = {}
    for n_clusters in (2, 3, 4, 6):
        ticc = TICC(n_clusters, WINDOW, max_iter=10).fit(X, lengths)
        found[n_clusters] = bic(X, lengths, ticc.labels_, WINDOW)
    assert min(found, key=found.get) == 3
    assert found[6] == max(found[n] for n in (3, 4, 6))


def test_motions_merged_or_split_at_will_have_a_higher_bic(swings):
    X, lengths, truth = swings
    true = bic(X, lengths, truth, WINDOW)
    merged = np.where(truth == 2, 0, truth)
    split = truth + 3 * (np.arange(len(truth)) // 150 % 2)
    many = truth + 3 * (np.arange(len(truth)) // 150)
    assert true < bic(X, lengths, split, WINDOW) < bic(X, lengths, many, WINDOW)
    assert true < bic(X, lengths, merged, WINDOW)


def test_labels_that_switch_at_random_have_a_higher_bic(swings):
    X, lengths, truth = swings
    rng = np.random.default_rng(0)
    noisy = np.where(rng.uniform(size=len(truth)) < 0.05, rng.integers(3, size=len(truth)), truth)
    assert bic(X, lengths, truth, WINDOW) < bic(X, lengths, noisy, WINDOW)


def test_a_switch_late_by_some_frames_has_a_higher_bic(swings):
    X, lengths, truth = swings
    assert bic(X, lengths, truth, WINDOW) < bic(X, lengths, np.roll(truth, 5), WINDOW)


def test_the_order_of_the_sequences_and_the_unit_of_a_channel_do_not_matter(swings):
    X, lengths, truth = swings
    cuts = np.cumsum(lengths)[:-1]
    order = [2, 0, 3, 1]
    mixed = np.concatenate([np.split(X, cuts)[i] for i in order])
    labels = np.concatenate([np.split(truth, cuts)[i] for i in order])
    known = bic(X, lengths, truth, WINDOW)
    assert bic(mixed, lengths[order], labels, WINDOW) == pytest.approx(known, rel=1e-9)
    assert bic(X * [1, 57.3] + 4, lengths, truth, WINDOW) == pytest.approx(known, rel=1e-6)


def test_the_likelihood_counts_each_frame_once():
    X = np.random.default_rng(1).multivariate_normal([0, 0], [[1, 0.6], [0.6, 1]], size=4000)
    X = (X - X.mean(axis=0)) / X.std(axis=0)
    expected = multivariate_normal([0, 0], np.cov(X.T, bias=True)).logpdf(X).sum()
    labels = np.zeros(len(X), dtype=int)
    assert log_likelihood(X, [len(X)], labels, 1) == pytest.approx(expected, rel=1e-4)
    assert log_likelihood(X, [len(X)], labels, 3) == pytest.approx(expected, rel=3e-3)


def test_a_cluster_of_a_few_frames_or_without_motion_does_not_win(swings):
    X, lengths, truth = swings
    few = truth.copy()
    few[100:103] = 3
    assert bic(X, lengths, truth, WINDOW) < bic(X, lengths, few, WINDOW)
    still = X.copy()
    still[200:260] = 0.0
    assert np.isfinite(bic(still, lengths, truth, WINDOW))
    twice = np.column_stack([X, X[:, 0]])
    assert np.isfinite(bic(twice, lengths, truth, WINDOW))


def test_a_path_has_the_probability_of_its_chain():
    labels, lengths = np.array([0, 0, 1, 1, 2, 2, 2]), [4, 3]
    switch = 1 / 5  # of the five steps within sequences
    expected = 2 * np.log(1 / 3) + np.log(switch / 2) + 4 * np.log(1 - switch)
    assert log_path(labels, lengths) == pytest.approx(expected)
    assert log_path(np.zeros(7, dtype=int), lengths) == 0
    assert log_path(np.arange(2), [1, 1]) == pytest.approx(2 * np.log(1 / 2))


def test_a_change_between_two_sequences_is_no_switch():
    assert n_switches(np.array([0, 0, 1, 1, 2]), [2, 3]) == 1
    assert n_switches(np.array([0, 1, 0]), [3]) == 2


def test_the_names_of_clusters_do_not_matter_for_stability():
    labels = np.array([0, 0, 1, 1, 2, 2])
    assert stability([labels, 2 - labels, labels]) == 1
    assert stability([labels, np.array([0, 1, 0, 1, 0, 1])]) < 0.1
    assert np.isnan(stability([labels]))


def test_fits_along_betas_are_as_good_as_fits_from_scratch(series):
    X, lengths, _ = series

    def make(beta):
        return TICC(n_clusters=3, window=WINDOW, beta=beta, max_iter=15)

    fits = along_betas(make, [20.0, 1.0, 5.0], X, lengths)
    assert set(fits) == {1.0, 5.0, 20.0}
    switches = [n_switches(fits[beta].labels_, lengths) for beta in (1.0, 5.0, 20.0)]
    assert switches == sorted(switches, reverse=True)
    for beta, fitted in fits.items():
        alone = make(beta).fit(X, lengths).objective_
        assert fitted.objective_ <= alone + 0.005 * abs(alone)
    alone = make(20.0).fit(X, lengths)
    assert fits[20.0].objective_ <= alone.objective_ + 1e-6
