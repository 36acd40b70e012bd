import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.annotation.runs import cluster_runs, run_changes, run_means, run_starts


def table(rows):
    return pd.DataFrame(rows, columns=["clip_id", "frame"])


def test_a_run_ends_where_the_clip_changes_and_where_frames_are_missing():
    frames = table([("a", 0), ("a", 1), ("a", 3), ("b", 4), ("b", 5), ("c", 0)])
    assert run_starts(frames).tolist() == [0, 2, 3, 5]


def test_a_run_of_a_value_ends_where_the_value_changes_too():
    frames = table([("a", 0), ("a", 1), ("a", 2), ("b", 3)])
    assert run_starts(frames, np.array([7, 7, 5, 5])).tolist() == [0, 2, 3]


def test_no_frame_gives_no_run():
    assert run_starts(table([])).tolist() == []


def test_a_runs_mean_and_rise_are_of_its_own_frames():
    rows = [("a", 0, 0), ("a", 1, 0), ("a", 2, 0), ("a", 3, 1), ("b", 0, 1), ("b", 1, 1)]
    clusters = pd.DataFrame(rows, columns=["clip_id", "frame", "cluster"]).assign(margin=1.0)
    values = np.array([[0.0], [1.0], [2.0], [5.0], [4.0], [2.0]])
    runs = cluster_runs(clusters)
    assert run_means(runs, values).tolist() == [[1.0], [5.0], [3.0]]
    assert run_changes(runs, values).tolist() == [[2.0], [0.0], [-2.0]]


def test_no_run_has_no_mean():
    runs = cluster_runs(tables.empty(tables.CLUSTERS))
    assert run_means(runs, np.empty((0, 2))).shape == (0, 2)
    assert run_changes(runs, np.empty((0, 2))).shape == (0, 2)
