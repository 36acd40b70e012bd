import numpy as np
import pytest

from mimeline.ticc.descent import Setting, descend


def setting(max_iter, sparsity=0.11):
    return Setting(n_clusters=3, beta=5.0, sparsity=sparsity, max_iter=max_iter, penalised=True)


def test_each_iteration_lowers_the_objective_where_no_border_cuts_much(plant, windows_of):
    X, truth = plant([2000])
    X = (X - X.mean(axis=0)) / X.std(axis=0)
    labels = (truth + (np.random.default_rng(0).random(2000) < 0.3)) % 3  # a poor start
    windows = windows_of(X, [2000], 4)
    reached = [descend(windows, labels, setting(n)).objective for n in (1, 2, 3, 4)]
    assert (np.diff(reached) <= 0).all() and reached[-1] < reached[0]


def test_it_says_whether_the_labels_settled(plant, windows_of):
    X, truth = plant([600])
    windows = windows_of(X, [600], 4)
    short = descend(windows, np.roll(truth, 20), setting(1))
    assert not short.converged and short.iterations == 1
    long = descend(windows, np.roll(truth, 20), setting(50))
    assert long.converged and long.iterations < 50


@pytest.mark.parametrize("sparsity", [0.0, 0.11])
def test_a_cluster_without_frames_is_given_some_and_windows_all_alike_stay_bounded(
    sparsity, windows_of
):
    rng = np.random.default_rng(0)
    X = np.concatenate([np.zeros((200, 2)), rng.normal(size=(200, 2)) + 3])
    fit = descend(windows_of(X, [200, 200], 3), np.repeat([0, 1], 200), setting(10, sparsity))
    precisions = fit.gaussians.precisions
    assert np.isfinite(fit.objective) and np.isfinite(precisions).all()
    assert (fit.labels[:200] == 0).all()
    assert np.linalg.eigvalsh(precisions).min() > 0
    assert set(fit.labels[200:]) == {1, 2}
