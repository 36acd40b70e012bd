import os

import pandas as pd
import pytest

from mimeline.annotation import fits
from mimeline.annotation.fits import recall, remember


@pytest.fixture
def clusters():
    return pd.DataFrame(
        {"clip_id": ["a"] * 5 + ["b"], "frame": [0, 1, 2, 5, 6, 0], "cluster": [0, 0, 1, 1, 1, 1]}
    ).assign(margin=1.0)


def test_what_is_remembered_is_recalled_as_stretches_of_frames(tmp_path, clusters):
    remember(tmp_path, "brow", "f1", clusters)
    rows = recall(tmp_path, "brow", "f1").to_numpy().tolist()
    assert rows == [["a", 0, 2, 0], ["a", 2, 3, 1], ["a", 5, 7, 1], ["b", 0, 1, 1]]


def test_a_fit_that_nobody_kept_is_unknown(tmp_path):
    assert recall(tmp_path / "none", "brow", "f1") is None


def test_a_fit_is_kept_by_the_present_names_of_its_clips(tmp_path, clusters):
    remember(tmp_path, "brow", "f1", clusters)
    remember(tmp_path, "brow", "f1", clusters.replace({"clip_id": {"a": "new"}}))
    assert set(recall(tmp_path, "brow", "f1")["clip_id"]) == {"new", "b"}


@pytest.mark.parametrize("left", [0, 100])
def test_a_truncated_file_is_unknown_and_told_and_replaced(tmp_path, clusters, caplog, left):
    remember(tmp_path, "brow", "f1", clusters)
    path = tmp_path / "brow-f1.parquet"
    path.write_bytes(path.read_bytes()[:left])
    assert recall(tmp_path, "brow", "f1") is None
    assert "brow-f1.parquet" in caplog.text
    remember(tmp_path, "brow", "f1", clusters)
    assert len(recall(tmp_path, "brow", "f1")) == 4


def test_of_many_fits_those_used_last_are_kept_and_other_regions_are_not_touched(
    tmp_path, clusters, monkeypatch
):
    monkeypatch.setattr(fits, "MOST", 3)
    remember(tmp_path, "eye", "f0", clusters)
    for number in range(3):
        remember(tmp_path, "brow", f"f{number}", clusters)
        os.utime(tmp_path / f"brow-f{number}.parquet", (number, number))
    recall(tmp_path, "brow", "f0")
    remember(tmp_path, "brow", "f3", clusters)
    left = sorted(path.stem for path in tmp_path.iterdir())
    assert left == ["brow-f0", "brow-f2", "brow-f3", "eye-f0"]
