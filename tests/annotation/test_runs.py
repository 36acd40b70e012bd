import numpy as np
import pandas as pd

from mimeline.annotation.runs import run_starts


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
