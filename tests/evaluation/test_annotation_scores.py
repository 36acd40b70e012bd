from typing import NamedTuple

import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.annotation.annotate import annotate_frames
from mimeline.annotation.proposals import read_rules
from mimeline.annotation.series import concatenate
from mimeline.annotation.thresholds import Limits
from mimeline.evaluation.annotation import by_thresholds, evaluate_annotation, oracle
from mimeline.vocabulary import ACTIONS, SERIES_REGIONS, resource, series_channels

ANNOTATE = {"closed": 0.5, "gaze_deg": 8.0, "head_deg": 8.0, "hysteresis": 0.0, "min_frames": 1}
RULES = read_rules(resource("proposals.csv"))
CLIPS, LENGTH = ["a", "b", "c"], 60
STATE = np.arange(len(CLIPS) * LENGTH) // 10 % 3  # neutral, BrowUp, BrowDown


def keys_of(clips=CLIPS, length=LENGTH) -> pd.DataFrame:
    rows = [(clip, frame) for clip in clips for frame in range(length)]
    return pd.DataFrame(rows, columns=["clip_id", "frame"])


def frames_of(keys, **marks) -> pd.DataFrame:
    """A `frames` table: what is given is measured, and so is the rest of its track."""
    table = keys.assign(**dict.fromkeys(ACTIONS, pd.NA))
    return table.assign(**{name: pd.array(v, dtype="boolean") for name, v in marks.items()})


def brow(state) -> dict:
    return {"BrowUp": state == 1, "BrowDown": state == 2}


class Scored(NamedTuple):
    metrics: pd.DataFrame
    confusion: pd.DataFrame
    reason: str


@pytest.fixture
def world(tmp_path):
    """Writes all that evaluate_annotation reads: the brow planted, the rest not measured.

    clusters: of the brow, one per frame or None; predicted: the state that annotate told; truth:
    marks by action, or None.
    """
    planted = brow(STATE)

    def world(clusters, predicted=STATE, truth=planted):
        rng = np.random.default_rng(0)
        keys = keys_of()
        channels = list(series_channels("brow", "left"))
        values = 0.6 * np.array([[0, 0, 0], [0, 1, 1], [1, 0, 0]])[STATE]
        values = values + 0.02 * rng.normal(size=values.shape) + 0.1  # (n_frames, 3)
        moving = keys.assign(**dict(zip(channels, values.T, strict=True)))
        motion = moving.reindex(columns=tables.MOTION.schema.names).assign(valid=True)
        clips = pd.DataFrame({"clip_id": CLIPS}).reindex(columns=tables.CLIPS.schema.names)
        clips = clips.assign(source_id="s", start_s=0.0, end_s=2.0, shard=0)
        for name in ("actions", "emotions", "attributes", "texts"):
            clips[name] = pd.Series([[]] * len(CLIPS), dtype=object)
        tables.write(tables.CLIPS, clips, tmp_path / "clips.parquet")
        tables.write(tables.MOTION, motion, tmp_path / "motion.parquet")
        named = frames_of(keys, **brow(predicted))
        tables.write(tables.FRAMES, named, tmp_path / "annotated.parquet")
        (tmp_path / "truth").mkdir(exist_ok=True)
        if truth is not None:
            true = frames_of(keys, **truth)
            tables.write(tables.FRAMES, true, tmp_path / "truth" / "frames.parquet")
        series, assigned = {}, {}
        for region in SERIES_REGIONS:
            series[region] = tmp_path / f"{region}.series.parquet"
            assigned[region] = tmp_path / f"{region}.clusters.parquet"
            contract = tables.SERIES[region, "left"]
            tables.write(contract, tables.empty(contract), series[region], "not measured")
            tables.write(tables.CLUSTERS, tables.empty(tables.CLUSTERS), assigned[region], "empty")
        if clusters is not None:
            table = concatenate(moving, channels, 100, -1.0)
            tables.write(tables.SERIES["brow", "left"], table, series["brow"])
            rows = keys.assign(cluster=clusters, margin=1.0)
            tables.write(tables.CLUSTERS, rows, assigned["brow"])
        out, shares = tmp_path / "metrics.parquet", tmp_path / "confusion.parquet"
        evaluate_annotation(
            [tmp_path / "clips.parquet"],
            [],
            [tmp_path / "motion.parquet"],
            [tmp_path / "annotated.parquet"],
            series,
            assigned,
            resource("proposals.csv"),
            tmp_path / "truth" if truth is not None else None,
            out,
            shares,
            side="left",
            annotate=ANNOTATE,
            gmm_components=3,
            overlap=0.5,
            resamples=50,
            seed=0,
        )
        assert tables.reason(out) == tables.reason(shares)
        return Scored(
            tables.read(tables.METRICS, out).set_index(["variant", "metric"]),
            tables.read(tables.CONFUSION, shares).set_index(["variant", "track", "truth", "found"]),
            tables.reason(out),
        )

    return world


def test_clusters_that_tell_the_states_apart_score_one_by_oracle_names(world):
    swapped = np.array([4, 0, 2])[STATE]
    metrics, *_ = world(swapped, predicted=np.zeros_like(STATE))
    assert metrics.loc[("oracle", "f1_brow"), ["value", "low", "high"]].tolist() == [1, 1, 1]
    assert metrics.loc[("gmm", "f1_brow"), "value"] == pytest.approx(1)
    assert metrics.loc[("named", "f1_brow"), "value"] == pytest.approx((2 / 4) / 3)
    assert metrics.loc[("named", "f1_brow"), "n"] == len(STATE)


def test_thresholds_name_each_frame_whatever_its_cluster(world):
    metrics, *_ = world(np.zeros_like(STATE), predicted=np.zeros_like(STATE))
    assert metrics.loc[("thresholds", "f1_brow"), "value"] == 1
    assert metrics.loc[("oracle", "f1_brow"), "value"] == pytest.approx((2 / 4) / 3)


def test_what_was_not_measured_has_no_row(world):
    metrics, confusion, _ = world(STATE)
    regions = metrics.index.get_level_values("metric").str.rpartition("_").get_level_values(2)
    assert set(regions) == {"brow"}
    assert set(confusion.index.get_level_values("track")) == {"brow"}


def test_scores_repeat_for_a_seed(world):
    wrong = np.where(np.arange(len(STATE)) % 7 == 0, 0, STATE)
    first, again = (world(wrong, predicted=wrong) for _ in range(2))
    pd.testing.assert_frame_equal(first.metrics, again.metrics)
    pd.testing.assert_frame_equal(first.confusion, again.confusion)
    for table, value in ((first.metrics, "value"), (first.confusion, "share")):
        assert (table["low"] <= table[value]).all()
        assert (table[value] <= table["high"]).all()


LATE = np.roll(STATE, 2)  # every edge two frames late, but for what is cut off at the ends


def test_intervals_and_their_edges_are_scored_beside_the_frames(world):
    metrics, *_ = world(STATE, predicted=LATE)
    named = metrics.loc["named"]
    assert named.loc["segment_precision_brow", "value"] == 12 / 15  # each clip begins with a piece
    assert named.loc["segment_recall_brow", "value"] == 1
    assert named.loc["start_bias_brow", "value"] == named.loc["end_mean_brow", "value"] == 2
    assert named.loc["boundary_within_2_brow", "value"] == 1
    assert named.loc["segment_recall_brow", "n"] == 12
    perfect = metrics.loc["oracle"]["value"]
    assert perfect["segment_f1_brow"] == 1
    assert perfect["boundary_mean_brow"] == perfect["start_bias_brow"] == 0


def test_a_score_without_a_value_has_no_row(world):
    metrics, *_ = world(STATE, predicted=np.zeros_like(STATE))
    assert metrics.loc[("named", "segment_recall_brow"), "value"] == 0
    assert ("named", "segment_precision_brow") not in metrics.index
    assert ("named", "boundary_mean_brow") not in metrics.index


def test_what_each_true_action_was_found_to_be_is_told_with_its_share(world):
    raised = np.where(STATE == 2, 1, STATE)
    _, confusion, _ = world(STATE, predicted=raised)
    own = confusion.loc[("named", "brow")]
    assert own.loc[("BrowDown", "BrowUp"), "frames"] == (STATE == 2).sum()
    assert own.loc[("BrowDown", "BrowUp"), ["share", "low", "high"]].tolist() == [1, 1, 1]
    assert own.loc[("Neutral", "BrowUp"), "share"] == 0
    assert own.groupby("truth")["share"].sum().tolist() == [1, 1, 1]
    assert own["frames"].sum() == len(STATE)


def test_where_no_region_was_segmented_the_annotation_is_scored_all_the_same(world):
    metrics, *_ = world(None)
    assert metrics.loc[("named", "f1_brow"), "value"] == 1
    assert "f1_brow" not in metrics.drop("named").index.get_level_values("metric")


def brow_frames(up, down) -> pd.DataFrame:
    """Ninety frames at rest, then one for each pair of how far the brow goes up and down."""
    values = np.concatenate([np.zeros((90, 3)), np.column_stack([down, up, up])])  # (n_frames, 3)
    channels = series_channels("brow", "left")
    return keys_of(["a"], len(values)).assign(**dict(zip(channels, values.T, strict=True)))


def test_a_single_frame_is_named_by_the_rules():
    frames = brow_frames(up=[0.6] * 3 + [0] * 6, down=[0] * 3 + [0.6] * 3 + [0.01] * 3)
    clusters, labels = by_thresholds(frames, RULES, "brow", "left")
    names = clusters["cluster"].map(labels.set_index("cluster")["action"])
    assert names.tolist() == ["Neutral"] * 90 + ["BrowUp"] * 3 + ["BrowDown"] * 3 + ["Neutral"] * 3


def test_thresholds_do_not_tell_an_action_whose_channel_never_moves():
    frames = brow_frames(up=[0.6] * 9, down=[0] * 9)
    clusters, labels = by_thresholds(frames, RULES, "brow", "left")
    motion = keys_of(["a"], len(frames)).reindex(columns=tables.MOTION.schema.names)
    found = annotate_frames(
        motion.assign(valid=True), {"brow": clusters}, labels, Limits(**ANNOTATE)
    )
    assert found["BrowDown"].isna().all()
    assert found["BrowUp"].tolist() == [False] * 90 + [True] * 9


def test_without_a_truth_the_table_is_empty_and_says_so(world):
    metrics, confusion, reason = world(STATE, truth=None)
    assert metrics.empty and confusion.empty
    assert reason == "no truth is known for these recordings"


def test_a_truth_that_measures_something_else_leaves_an_empty_table_that_says_so(world):
    metrics, confusion, reason = world(STATE, truth={"HeadUp": STATE == 1, "HeadDown": STATE == 2})
    assert metrics.empty and confusion.empty
    assert reason == "truth and annotation measure no frame in common"


def clusters_of(keys, ids):
    return keys.assign(cluster=ids, margin=1.0)


def test_oracle_names_agree_with_truth_as_often_as_names_can():
    rng = np.random.default_rng(0)
    keys = keys_of(["a"], 200)
    state, ids = rng.integers(0, 3, 200), rng.integers(0, 3, 200)
    true = frames_of(keys, **brow(state))

    def agreement(names):
        labels = pd.DataFrame({"region": "brow", "cluster": range(3), "action": names})
        motion = keys.reindex(columns=tables.MOTION.schema.names).assign(valid=True)
        found = annotate_frames(
            motion, {"brow": clusters_of(keys, ids)}, labels, Limits(**ANNOTATE)
        )
        return (found[["BrowUp", "BrowDown"]] == true[["BrowUp", "BrowDown"]]).all(axis=1).sum()

    classes = ["Neutral", "BrowUp", "BrowDown"]
    best = oracle(true, clusters_of(keys, ids), "brow")["action"].tolist()
    others = np.stack(np.meshgrid(*[classes] * 3), axis=-1).reshape(-1, 3)  # all 27 namings
    assert agreement(best) == max(agreement(list(names)) for names in others)


def test_frames_whose_eye_is_closed_do_not_name_a_cluster_of_the_eye():
    keys = keys_of(["a"], 5)
    squint = np.array([True, True, True, False, False])
    closed = np.array([True, True, True, False, False])
    true = frames_of(keys, EyeSquint=squint, EyeWiden=[False] * 5, EyeClose=closed)
    clusters = clusters_of(keys, [1] * 5)
    assert oracle(true, clusters, "eye")["action"].tolist() == ["Neutral", "Neutral"]
    open_eyes = true.assign(EyeClose=pd.array([False] * 5, dtype="boolean"))
    assert oracle(open_eyes, clusters, "eye")["action"].tolist() == ["Neutral", "EyeSquint"]
