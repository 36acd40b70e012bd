import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.annotation.fitted import read_fingerprint
from mimeline.annotation.region_model import RegionModel, read_models
from mimeline.annotation.segment import segment
from mimeline.annotation.series import concatenate
from mimeline.errors import BadFile
from mimeline.ticc import TICC
from mimeline.vocabulary import series_channels

EYE = list(series_channels("eye", "left"))
OPTIONS = {"window": 3, "beta": 5.0, "sparsity": 0.1, "max_iter": 3, "seed": 0}
OPTIONS |= {"boundary": "mask", "null_length": 100, "null_value": -1.0}


@pytest.fixture
def run(tmp_path):
    def run(lengths, values=None, n_clusters=2, **options):
        keys = [(f"c{i}", frame) for i, length in enumerate(lengths) for frame in range(length)]
        frames = pd.DataFrame(keys, columns=["clip_id", "frame"])
        frames[EYE] = np.random.default_rng(0).uniform(size=(len(frames), 2))
        table = concatenate(frames.assign(**(values or {})), EYE, 100, -1.0)
        tables.write(tables.SERIES["eye", "left"], table, tmp_path / "series.parquet")
        model, clusters = tmp_path / "model", tmp_path / "clusters.parquet"
        paths = tmp_path / "series.parquet", model, clusters
        segment(*paths, region="eye", side="left", n_clusters=n_clusters, **OPTIONS | options)
        return tables.read(tables.CLUSTERS, clusters), tables.reason(clusters), model

    return run


def test_every_frame_of_the_series_and_no_separator_gets_a_cluster(segmented):
    clusters = tables.read(tables.CLUSTERS, segmented.clusters["brow"])
    keys = segmented.motion[["clip_id", "frame"]]
    pd.testing.assert_frame_equal(clusters[["clip_id", "frame"]], keys, check_dtype=False)
    assert set(clusters["cluster"]) == {0, 1, 2}


def test_clusters_follow_planted_motion(segmented):
    clusters = tables.read(tables.CLUSTERS, segmented.clusters["brow"])
    planted = np.arange(720) // 40 % 3
    counts = pd.crosstab(planted, clusters["cluster"]).to_numpy()
    assert counts.max(axis=1).sum() > 0.95 * 720
    assert len(set(counts.argmax(axis=1))) == 3


def test_the_saved_model_decodes_to_the_written_clusters(segmented):
    clusters = tables.read(tables.CLUSTERS, segmented.clusters["eye"])
    X = segmented.motion[EYE].to_numpy("float32").astype("float64")
    labels, margins = TICC.load(segmented.models["eye"]).decode(X, [240] * 3)
    assert labels.tolist() == clusters["cluster"].tolist()
    assert margins == pytest.approx(clusters["margin"].to_numpy(), rel=1e-5)


def test_separators_are_clustered_where_the_boundary_is_the_papers(run):
    clusters, reason, model = run([60, 70], boundary="paper")
    assert not reason and len(clusters) == 130
    assert len(RegionModel.load(model).ticc.means_) == 3


def test_a_region_without_a_series_passes_the_reason_on(segmented):
    reason = tables.reason(segmented.clusters["mouth"])
    assert reason == "not measured: mouthSmileLeft, mouthStretchLeft, mouthFrownLeft"
    assert tables.read(tables.CLUSTERS, segmented.clusters["mouth"]).empty
    (segmented.models["mouth"] / ".snakemake_timestamp").touch()
    assert set(read_models(segmented.models)) == {"brow", "eye"}


def test_too_few_frames_leave_an_empty_model_and_a_reason(run):
    clusters, reason, model = run([30, 31])
    assert clusters.empty
    assert reason == "57 windows of 3 frames are too few for 2 clusters: 60 are needed"
    assert list(model.iterdir()) == []


def test_just_enough_frames_are_segmented(run):
    clusters, reason, model = run([31, 33])
    assert len(clusters) == 64
    assert reason == ""
    assert TICC.load(model).n_clusters == 2


def test_many_sequences_shorter_than_a_window_are_too_little(run):
    clusters, reason, _ = run([2] * 200)
    assert clusters.empty
    assert reason.startswith("0 windows of 3 frames are too few")


def test_a_channel_that_never_moves_is_left_out_of_the_model(run):
    clusters, reason, model = run([200], {"eyeWideLeft": 0.25})
    assert len(clusters) == 200
    assert reason == ""
    assert RegionModel.load(model).channels == ("eyeSquintLeft",)


def test_one_odd_frame_does_not_make_a_channel_move(run):
    glitch = np.full(200, 0.25)
    glitch[70] = 0.9
    _, _, model = run([200], {"eyeWideLeft": glitch})
    assert RegionModel.load(model).channels == ("eyeSquintLeft",)


def test_a_region_of_which_no_channel_moves_is_not_segmented(run):
    clusters, reason, model = run([200], {"eyeWideLeft": 0.25, "eyeSquintLeft": 0.1})
    assert clusters.empty
    assert reason == "never moves: eyeSquintLeft, eyeWideLeft"
    assert list(model.iterdir()) == []


def test_a_folder_that_holds_no_model_says_what_to_do(tmp_path):
    (tmp_path / "channels.json").write_text("[")
    with pytest.raises(BadFile, match="run segment again"):
        RegionModel.load(tmp_path)
    with pytest.raises(BadFile, match="run segment again"):
        read_fingerprint(tmp_path)
