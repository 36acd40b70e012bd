import numpy as np
import pandas as pd
import pytest

from mimeline.ticc import TICC
from mimeline.ticc.parquet import ParquetFrames


@pytest.fixture(scope="module")
def shards(series, tmp_path_factory):
    """The series in two files of small row groups, separators between the sequences."""
    X, lengths, _ = series
    folder = tmp_path_factory.mktemp("shards")
    tables = []
    for number, part in enumerate(np.split(X, np.cumsum(lengths)[:-1])):
        rows = pd.DataFrame(part, columns=["a", "b", "c"])
        gap = pd.DataFrame(-1.0, index=range(5), columns=["a", "b", "c"])
        tables += [rows.assign(clip=f"clip {number}", frame=range(7, 7 + len(part))), gap]
    paths = [folder / "0.parquet", folder / "1.parquet"]
    for path, some in zip(paths, (tables[:8], tables[8:]), strict=True):
        pd.concat(some).astype({"frame": "Int64"}).to_parquet(path, row_group_size=33)
    return paths


@pytest.fixture(scope="module")
def frames(shards):
    return ParquetFrames(shards, ["a", "b", "c"], "clip", "frame")


def test_files_give_the_frames_and_the_sequences_that_were_written(frames, series):
    X, lengths, _ = series
    assert frames.lengths.tolist() == lengths.tolist() and frames.n_channels == 3
    for begin, end in ((0, len(X)), (0, 1), (30, 36), (200, 500), (len(X) - 1, len(X))):
        assert np.array_equal(frames.read(begin, end), X[begin:end])


def test_a_fit_of_files_is_the_fit_of_what_they_hold(frames, series, fitted):
    X, lengths, _ = series
    model = TICC(n_clusters=3, window=4, beta=5.0, max_iter=15).fit(frames)
    assert np.array_equal(model.labels_, fitted.labels_)
    labels, margins = model.decode(frames)
    expected = fitted.decode(X, lengths)
    assert np.array_equal(labels, expected[0]) and np.allclose(margins, expected[1])


def test_null_sequences_stand_between_the_sequences_of_files(frames, series):
    X, lengths, _ = series
    paper = TICC(n_clusters=3, window=4, beta=5.0, boundary="paper", max_iter=5)
    assert np.array_equal(paper.fit(frames).labels_, paper.fit(X, lengths).labels_)


def test_null_sequences_may_be_longer_than_any_block(frames):
    paper = TICC(n_clusters=3, window=4, boundary="paper", max_iter=2, null_length=3000)
    assert len(paper.fit(frames).labels_) == frames.lengths.sum()
    assert frames.read(0, 0).shape == (0, 3)


def test_a_gap_in_the_count_of_frames_ends_a_sequence(tmp_path):
    path = tmp_path / "gap.parquet"
    rows = pd.DataFrame({"clip": ["x"] * 6, "frame": [0, 1, 2, 5, 6, 7], "a": np.arange(6.0)})
    rows.to_parquet(path, row_group_size=2)
    assert ParquetFrames([path], ["a"], "clip", "frame").lengths.tolist() == [3, 3]


def test_a_count_of_frames_that_does_not_go_up_by_one_is_told_of(tmp_path, caplog):
    rows = pd.DataFrame({"clip": ["x"] * 6, "frame": range(0, 12, 2), "a": np.arange(6.0)})
    rows.to_parquet(tmp_path / "odd.parquet")
    ParquetFrames([tmp_path / "odd.parquet"], ["a"], "clip", "frame")
    assert "does 'frame' go up by one from row to row?" in caplog.text


def test_what_cannot_be_read_is_refused_with_its_file(shards, tmp_path):
    with pytest.raises(ValueError, match=r"0\.parquet: found no column 'd'"):
        ParquetFrames(shards, ["a", "d"], "clip", "frame")
    with pytest.raises(
        ValueError, match=r"0\.parquet, column 'clip': found .*string, expected numb"
    ):
        ParquetFrames(shards, ["a", "clip"], "clip", "frame")
    with pytest.raises(ValueError, match="channels: found none"):
        ParquetFrames(shards, [], "clip", "frame")
    broken = tmp_path / "broken.parquet"
    broken.write_bytes(b"PAR1 and no more")
    with pytest.raises(ValueError, match=r"broken\.parquet: "):
        ParquetFrames([broken], ["a"], "clip", "frame")
    with pytest.raises(ValueError, match="found no frames"):
        ParquetFrames([], ["a"], "clip", "frame")
