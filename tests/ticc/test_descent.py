import numpy as np
import pytest

from mimeline.ticc.descent import descend


def test_each_iteration_lowers_the_objective_where_no_border_cuts_much(plant):
    X, truth = plant([2000])
    X = (X - X.mean(axis=0)) / X.std(axis=0)
    labels = (truth + (np.random.default_rng(0).random(2000) < 0.3)) % 3  # a poor start
    lengths = np.array([2000])
    reached = [
        descend(X, lengths, labels, 3, 4, 5.0, 0.11, max_iter=n).objective for n in (1, 2, 3, 4)
    ]
    assert (np.diff(reached) <= 0).all() and reached[-1] < reached[0]


def test_it_says_whether_the_labels_settled(plant):
    X, truth = plant([600])
    lengths = np.array([600])
    short = descend(X, lengths, np.roll(truth, 20), 3, 4, 5.0, 0.11, max_iter=1)
    assert not short.converged and short.iterations == 1
    long = descend(X, lengths, np.roll(truth, 20), 3, 4, 5.0, 0.11, max_iter=50)
    assert long.converged and long.iterations < 50


@pytest.mark.parametrize("sparsity", [0.0, 0.11])
def test_a_cluster_without_frames_is_given_some_and_windows_all_alike_stay_bounded(sparsity):
    rng = np.random.default_rng(0)
    X = np.concatenate([np.zeros((200, 2)), rng.normal(size=(200, 2)) + 3])
    lengths = np.array([200, 200])
    fit = descend(X, lengths, np.repeat([0, 1], 200), 3, 3, 5.0, sparsity, max_iter=10)
    assert np.isfinite(fit.objective) and np.isfinite(fit.lasso.precisions).all()
    assert (fit.labels[:200] == 0).all()
    assert np.linalg.eigvalsh(fit.lasso.precisions).min() > 0
    assert 0 not in fit.labels[200:]
