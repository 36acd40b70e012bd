from pathlib import Path

import numpy as np
import pytest
from sklearn.metrics import adjusted_rand_score

from mimeline.ticc import TICC
from mimeline.ticc.reference import cheapest_path, forward_windows, reference_iterations

# Made by the original code itself, with nothing changed but what NumPy 2 needs and the start given.
RUNS = (
    "plain",
    "frames_alone_and_free_switches",  # window 1, beta 0
    "one_channel",
    "long_segments",  # the code's default beta of 400
    "null_sequences",  # channels in [0, 1], 100 frames of -1 between clips
    "emptied_later",  # from the second iteration on, and refilled each time
    "emptied_at_once",  # by the first iteration, which does not refill
    "emptied_and_back",  # the same, and the cluster returns by its old estimates
    "refill_covered",  # a refilled run is covered whole by that of another cluster
)


def original(name):
    with np.load(Path(__file__).parent / "reference_cases.npz") as stored:
        return {k.split("/")[1]: stored[k] for k in stored.files if k.startswith(f"{name}/")}


def settings(run):
    n_clusters, window, beta, sparsity, max_iter = run["settings"]
    return int(n_clusters), int(window), beta, sparsity, int(max_iter)


def ours(run):
    return list(reference_iterations(run["X"], *settings(run), run["start"]))


def estimator_labels(run, iterations):
    """Of the frames whose trailing window is full, in the order of the original's windows."""
    n_clusters, window, beta, sparsity, _ = settings(run)
    model = TICC(
        n_clusters=n_clusters,
        window=window,
        beta=beta / 2,
        sparsity=sparsity,
        alignment="trailing",
        standardise=False,
        cost="likelihood",
        boundary="mask",
        max_iter=iterations,
    )
    start = np.pad(run["start"].astype(np.int64), (window - 1, 0), mode="edge")
    return model.fit(run["X"], start=start).labels_[window - 1 :]


@pytest.mark.parametrize("name", RUNS)
def test_every_label_of_every_iteration_is_the_originals(name):
    run = original(name)
    found = ours(run)
    assert len(found) == len(run["labels"])  # and it stops where the original stops
    for iteration, assigned, labels in zip(found, run["assigned"], run["labels"], strict=True):
        assert np.array_equal(iteration.assigned, assigned)
        assert np.array_equal(iteration.labels, labels)
    assert np.allclose(found[-1].means, run["means"], rtol=0, atol=1e-10)
    assert np.allclose(found[-1].precisions, run["precisions"], rtol=0, atol=1e-10)


@pytest.mark.parametrize("name", ["plain", "one_channel", "null_sequences"])
def test_the_estimator_labels_as_the_original_does(name):
    run = original(name)
    found = estimator_labels(run, len(run["labels"]))
    assert adjusted_rand_score(run["labels"][-1], found) >= 0.999


@pytest.mark.parametrize("name", ["long_segments", "frames_alone_and_free_switches"])
def test_the_estimator_labels_as_the_mended_original_where_the_originals_flaws_decide(name):
    run = original(name)
    mended = next(reference_iterations(run["X"], *settings(run), run["start"], mended=True)).labels
    assert adjusted_rand_score(run["labels"][0], mended) < 0.995
    assert adjusted_rand_score(mended, estimator_labels(run, iterations=1)) >= 0.999


@pytest.mark.parametrize("beta", [0, 1, 3])
def test_ties_fall_as_in_the_loop_over_all_pairs_of_clusters(beta):
    costs = np.random.default_rng(0).integers(0, 3, size=(300, 4)).astype(float)
    switch = beta * (1 - np.eye(4))
    ahead = np.zeros((301, 4))  # the cheapest rest from each frame on, by the cluster before it
    for t in range(299, -1, -1):
        ahead[t] = (switch + costs[t] + (ahead[t + 1] if t < 299 else 0)).min(axis=1)
    path = [int((costs[0] + ahead[1]).argmin())]
    for t in range(1, 300):
        path.append(int((switch[path[-1]] + costs[t] + ahead[t + 1]).argmin()))
    assert cheapest_path(costs, beta).tolist() == path


def test_windows_look_forward_and_the_last_frames_are_never_read():
    X = np.arange(1.0, 6.0)[:, None]
    assert forward_windows(X, 3).tolist() == [[1, 2, 3], [2, 3, 0], [3, 0, 0]]
    assert forward_windows(X, 3, mended=True).tolist() == [[1, 2, 3], [2, 3, 4], [3, 4, 5]]


def test_what_the_original_fails_on_is_refused():
    X = np.random.default_rng(0).normal(size=(50, 2))
    start = np.zeros(48, int)
    with pytest.raises(ValueError, match="empty cluster"):
        next(reference_iterations(X, 2, 3, 5, 0.11, 5, start))
    start[7] = 1
    with pytest.raises(ValueError, match="cluster 1: found one window"):
        next(reference_iterations(X, 2, 3, 5, 0.11, 5, start))
