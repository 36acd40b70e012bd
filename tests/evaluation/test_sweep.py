import weakref

import numpy as np
import pandas as pd
import pytest
from sklearn.metrics import f1_score

from mimeline import tables
from mimeline.annotation.series import concatenate
from mimeline.evaluation.sweep import best_f1, series_truth, sweep
from mimeline.ticc import TICC
from mimeline.ticc.selection import stability
from mimeline.vocabulary import ACTIONS, series_channels

EYE = list(series_channels("eye", "left"))
CONFIGURED = {"n_clusters": 3, "window": 3, "beta": 8.0, "sparsity": 0.1, "max_iter": 6, "seed": 5}
SEPARATORS = {"null_length": 80, "null_value": -2.0}


@pytest.fixture(scope="module")
def eyes() -> tuple[pd.DataFrame, pd.DataFrame]:
    """Two clips of eyes that rest, squint and widen: the channels by frame, and the truth."""
    rng = np.random.default_rng(0)
    keys = [(clip, frame) for clip in "ab" for frame in range(180)]
    frames = pd.DataFrame(keys, columns=["clip_id", "frame"])
    state = frames["frame"].to_numpy() // 20 % 3
    for channel, on in zip(EYE, (state == 1, state == 2), strict=True):
        frames[channel] = 0.1 + 0.5 * on + 0.04 * rng.normal(size=len(frames))
    truth = frames[["clip_id", "frame"]].assign(**dict.fromkeys(ACTIONS, False))
    return frames, truth.assign(EyeSquint=state == 1, EyeWiden=state == 2)


@pytest.fixture
def run(eyes, tmp_path):
    def run(
        n_clusters=(2,),
        betas=(2.0,),
        seeds=2,
        values=None,
        head=None,
        known=True,
        why="",
        configured=None,
    ):
        frames, truth = eyes
        frames = frames.assign(**(values or {})).head(len(frames) if head is None else head)
        table = concatenate(frames, EYE, **SEPARATORS)
        tables.write(tables.SERIES["eye", "left"], table, tmp_path / "series.parquet", why)
        (tmp_path / "truth").mkdir(exist_ok=True)
        tables.write(tables.FRAMES, truth, tmp_path / "truth" / "frames.parquet")
        scores = tmp_path / "scores.parquet"
        sweep(
            clips=[],
            ledgers=[],
            series=tmp_path / "series.parquet",
            truth=tmp_path / "truth" if known else None,
            scores=scores,
            region="eye",
            side="left",
            n_clusters=list(n_clusters),
            betas=list(betas),
            seeds=seeds,
            **SEPARATORS,
            configured=CONFIGURED | (configured or {}),
        )
        return tables.read(tables.SWEEP, scores), tables.reason(scores)

    return run


def test_every_point_of_the_grid_and_the_configured_one_is_fitted_with_every_seed(run):
    rows, reason = run()
    points = {(k, beta, seed) for k in (2, 3) for beta in (2.0, 8.0) for seed in (5, 6)}
    assert set(zip(rows["n_clusters"], rows["beta"], rows["seed"], strict=True)) == points
    assert reason == ""
    assert (rows.groupby(["n_clusters", "beta"])["stability"].nunique() == 1).all()
    best = rows[(rows["n_clusters"] == 3) & (rows["beta"] == 8)]
    assert (best["f1"] > 0.9).all()
    assert (best["stability"] > 0.9).all()
    assert (best["used"] == 3).all()
    assert best["mean_frames"].between(15, 25).all()
    assert rows.loc[rows["bic"].idxmin(), "n_clusters"] == 3


def test_the_same_sweep_gives_the_same_scores(run):
    rows, _ = run(seeds=1)
    assert len(rows) == 4
    pd.testing.assert_frame_equal(rows, run(seeds=1)[0])


def test_what_the_grid_holds_twice_is_fitted_once(run):
    rows, _ = run(n_clusters=[2, 3, 2], betas=[8, 2.0, 2], seeds=1)
    assert len(rows) == 4
    assert not rows.duplicated(["n_clusters", "beta", "seed"]).any()


def test_the_separators_of_the_series_are_those_that_are_clustered(run, monkeypatch):
    made = []

    class Remembered(TICC):
        def __init__(self, **parameters):
            super().__init__(**parameters)
            made.append(self)

    monkeypatch.setattr("mimeline.evaluation.sweep.TICC", Remembered)
    run(seeds=1, configured={"boundary": "paper"})
    assert {(ticc.null_length, ticc.null_value) for ticc in made} == {tuple(SEPARATORS.values())}


def test_labels_are_held_small_and_no_longer_than_their_cluster_count_is_at_work(run, monkeypatch):
    kept, alive, types = [], [], set()

    def watched(labels):
        kept.extend(weakref.ref(each) for each in labels)
        alive.append(sum(reference() is not None for reference in kept))
        types.update(each.dtype.name for each in labels)
        return stability(labels)

    monkeypatch.setattr("mimeline.evaluation.sweep.stability", watched)
    rows, _ = run()
    assert len(rows) == 8
    assert types == {"uint8"}
    assert alive == [2, 4, 2, 4]  # of two betas and two seeds, then of the next count


def test_without_truth_or_other_seeds_two_scores_are_not_known(run):
    rows, _ = run(seeds=1, known=False)
    assert rows["f1"].isna().all()
    assert rows["stability"].isna().all()
    assert rows["bic"].notna().all()


def test_more_clusters_than_the_frames_can_tell_are_not_tried(run):
    rows, _ = run(n_clusters=[2, 400], seeds=1)
    assert set(rows["n_clusters"]) == {2, 3}
    rows, reason = run(head=40)
    assert rows.empty
    assert reason == "38 windows of 3 frames are too few for 2 clusters: 60 are needed"


def test_a_region_without_a_series_passes_the_reason_on(run):
    rows, reason = run(head=0, why="not measured: eyeSquintLeft")
    assert rows.empty
    assert reason == "not measured: eyeSquintLeft"


def test_a_channel_that_never_moves_is_left_out(run):
    rows, _ = run(values={"eyeWideLeft": 0.2}, seeds=1)
    assert not rows.empty
    rows, reason = run(values={"eyeWideLeft": 0.2, "eyeSquintLeft": 0.2})
    assert rows.empty
    assert reason == "never moves: eyeSquintLeft, eyeWideLeft"


def test_frames_with_closed_eyes_or_without_a_truth_do_not_count(eyes):
    frames, truth = eyes
    closed = truth["frame"] == 25
    told = truth.assign(EyeClose=closed)[truth["frame"] != 50]
    codes = series_truth(frames, told, "eye")
    assert set(frames.loc[codes == -1, "frame"]) == {25, 50}
    assert codes[[0, 21, 41]].tolist() == [0, 1, 2]


def test_an_action_that_the_truth_does_not_tell_hides_no_other(eyes):
    frames, truth = eyes
    untold = truth.assign(EyeWiden=pd.array([pd.NA] * len(truth), dtype="boolean"))
    codes = series_truth(frames, untold, "eye")
    assert (codes == truth["EyeSquint"]).all()


def test_clusters_are_scored_by_the_name_of_most_of_their_frames():
    codes = np.array([0, 0, 0, 1, 1, 2, 2, -1, -1])
    labels = np.array([4, 4, 1, 1, 1, 0, 4, 0, 0])
    named = np.array([0, 0, 1, 1, 1, 2, 0])
    expected = f1_score(codes[:7], named, average="macro")
    assert best_f1(labels, codes, "eye") == pytest.approx(expected)
    assert np.isnan(best_f1(labels, np.full(9, -1), "eye"))
