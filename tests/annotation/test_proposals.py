import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.annotation.proposals import propose, read_rules
from mimeline.vocabulary import (
    ACTIONS,
    DESCRIPTORS,
    SERIES_REGIONS,
    resource,
    series_actions,
    series_channels,
)

FRAMES = 20  # of an interval
SHOWN = 8  # intervals of each planted cluster


@pytest.fixture(scope="module")
def rules():
    return read_rules(resource("proposals.csv"))


def series_of(parts, channels, rest=0.05, seed=0):
    """Clusters 0, 1, ...: each a list of excesses (n_channels,), which its intervals take in turn.

    Cluster 0 rests and has half of all intervals. Returns the `clusters` table and the values.
    """
    rng = np.random.default_rng(seed)
    parts = [[[0.0] * len(channels)] * (SHOWN * max(len(parts), 1)), *parts]
    intervals = [
        (k, own[i % len(own)])
        for k, own in enumerate(parts)
        for i in range(len(own) if k == 0 else SHOWN)
    ]
    rng.shuffle(intervals := np.array(intervals, dtype=object))
    rows = [
        (f"clip{i:03d}", frame, k) for i, (k, _) in enumerate(intervals) for frame in range(FRAMES)
    ]
    clusters = pd.DataFrame(rows, columns=["clip_id", "frame", "cluster"]).assign(margin=1.0)
    values = np.repeat(np.array([list(at) for _, at in intervals], dtype=float), FRAMES, axis=0)
    return clusters, values + rest + 0.02 * rng.normal(size=values.shape)


def proposed(region, excesses, rules, channels=None, rest=0.05):
    """Labels of clusters 1, 2, ... that each lie at one excess; cluster 0 rests."""
    channels = channels or series_channels(region, "left")
    clusters, values = series_of([[excess] for excess in excesses], channels, rest)
    return propose(region, clusters, values, channels, rules).set_index("cluster")


@pytest.mark.parametrize(
    ("region", "excesses", "expected"),
    [
        ("brow", [[0.5, 0, 0], [0, 0.4, 0.4], [0.05, 0, 0]], ["BrowDown", "BrowUp", "Neutral"]),
        ("eye", [[0.35, 0], [0, 0.35], [0.04, 0.04]], ["EyeSquint", "EyeWiden", "Neutral"]),
        (
            "mouth",
            [[0.32, 0, 0], [0.7, 0.2, 0], [0, 0, 0.3]],
            ["SoftSmile", "Smile", "MouthFrown"],
        ),
    ],
)
def test_planted_actions_get_their_names_with_confidence(rules, region, excesses, expected):
    labels = proposed(region, excesses, rules)
    assert labels["action"].tolist() == ["Neutral", *expected]
    assert (labels["confidence"] > 0.9).all()
    assert labels["why"].isna().all()


def test_the_stronger_of_two_actions_names_the_cluster(rules):
    assert proposed("brow", [[0.3, 0.5, 0.5]], rules).loc[1, "action"] == "BrowUp"
    assert proposed("brow", [[0.5, 0.3, 0.3]], rules).loc[1, "action"] == "BrowDown"


def test_a_face_that_rests_high_is_still_at_rest(rules):
    labels = proposed("brow", [[0, 0.4, 0.4]], rules, rest=0.3)
    assert labels["action"].tolist() == ["Neutral", "BrowUp"]


def test_what_is_high_and_no_action_is_not_neutral_but_told(rules):
    label = proposed("mouth", [[0.0, 0.5, 0.0]], rules).loc[1]
    assert pd.isna(label["action"]) and pd.isna(label["confidence"])
    assert label["why"] == "mouthStretch is high, which no action is"


def test_half_of_an_action_is_not_the_action_and_no_rest(rules):
    label = proposed("brow", [[0.0, 0.24, -0.03]], rules).loc[1]
    assert label["why"] == "browInnerUp alone is high, which no action is"


def test_half_way_between_two_names_neither_is_proposed(rules):
    label = proposed("mouth", [[0.5, 0.0, 0.0]], rules).loc[1]
    assert pd.isna(label["action"])
    assert set(label["why"].removeprefix("between ").split(" and ")) == {"SoftSmile", "Smile"}


def test_a_name_nearer_to_its_limit_is_less_sure(rules):
    labels = proposed("mouth", [[0.33, 0, 0], [0.43, 0, 0], [0.46, 0, 0]], rules)
    assert labels["action"].tolist()[1:] == ["SoftSmile"] * 3
    assert labels["confidence"].is_monotonic_decreasing
    assert labels.loc[3, "confidence"] < 0.85


def test_a_cluster_of_many_things_is_a_mixture(rules):
    channels = series_channels("mouth", "left")
    thirds = [[0.0, 0.0, 0.4], [0.33, 0.0, 0.0], [0.8, 0.0, 0.0], [0.0, 0.6, 0.0]]
    clusters, values = series_of([thirds, [[0.8, 0, 0]]], channels)
    labels = propose("mouth", clusters, values, channels, rules).set_index("cluster")
    assert pd.isna(labels.loc[1, "action"])
    assert labels.loc[1, "why"].startswith(("a mixture: 2", "between"))
    assert labels.loc[2, "action"] == "Smile"


def test_intervals_on_the_way_to_a_smile_are_no_soft_smile(rules):
    channels = series_channels("mouth", "left")
    clusters, values = series_of([[[0.0, 0, 0]], [[0.75, 0, 0]]], channels)
    rising = (clusters["cluster"] == 1).to_numpy()
    values[rising, 0] += np.tile(np.linspace(0.1, 0.75, FRAMES), SHOWN)
    labels = propose("mouth", clusters, values, channels, rules).set_index("cluster")
    assert labels.loc[1, "action"] == "Smile"


def test_actions_without_a_live_channel_are_unmeasured_and_never_proposed(rules):
    channels = ("mouthSmileLeft", "mouthStretchLeft")
    labels = proposed("mouth", [[0.7, 0.0], [0.0, 0.0]], rules, channels)
    assert labels["action"].tolist() == ["Neutral", "Smile", "Neutral"]
    assert labels["unmeasured"].map(list).tolist() == [["MouthFrown"]] * 3


def test_half_of_an_actions_channels_tell_it_where_the_other_half_is_dead(rules):
    labels = proposed("brow", [[0.4]], rules, ("browInnerUp",))
    assert labels.loc[1, "action"] == "BrowUp"
    assert labels.loc[1, "unmeasured"] == ["BrowDown"]


def test_where_no_action_can_be_told_nothing_is_neutral(rules):
    labels = proposed("mouth", [[0.5]], rules, ("mouthStretchRight",))
    assert labels["action"].isna().all()
    assert set(labels["why"]) == {"no action of the region is measured"}
    assert labels.loc[0, "unmeasured"] == ["SoftSmile", "Smile", "MouthFrown"]


def test_channels_may_come_in_any_order_and_of_either_side(rules):
    labels = proposed("eye", [[0.4, 0.0]], rules, ("eyeWideRight", "eyeSquintRight"))
    assert labels.loc[1, "action"] == "EyeWiden"


def test_clusters_keep_their_own_numbers_and_shares(rules, tmp_path):
    channels = series_channels("eye", "left")
    clusters, values = series_of([[[0.5, 0.0]]], channels)
    clusters["cluster"] = clusters["cluster"].map({0: 7, 1: 3})
    labels = propose("eye", clusters, values, channels, rules)
    tables.write(tables.LABELS, labels, tmp_path / "proposed.parquet")
    labels = tables.read(tables.LABELS, tmp_path / "proposed.parquet").set_index("cluster")
    assert labels["action"].to_dict() == {3: "EyeSquint", 7: "Neutral"}
    assert labels.loc[3, "share"] == pytest.approx(0.5)


def test_single_frames_are_classified_by_the_same_rules(rules):
    channels, rest = series_channels("mouth", "left"), np.array([0.1, 0.2, 0.2])
    excess = np.array([[0.0, 0, 0], [0.3, 0, 0], [0.6, 0, 0], [0, 0, 0.4], [0, 0.4, 0]])
    found = rules.classify("mouth", channels, rest + excess, rest)
    assert found.tolist() == ["Neutral", "SoftSmile", "Smile", "MouthFrown", None]


def test_one_interval_alone_is_at_rest(rules):
    channels = series_channels("brow", "left")
    clusters = pd.DataFrame({"clip_id": "a", "frame": range(10), "cluster": 0, "margin": 1.0})
    labels = propose("brow", clusters, np.full((10, 3), 0.1), channels, rules)
    assert labels["action"].tolist() == ["Neutral"]


def test_the_resource_has_a_rule_for_each_action_that_clusters_may_bear(rules):
    wanted = {action for region in SERIES_REGIONS for action in series_actions(region)}
    assert {rule.action for rule in rules.actions} == wanted <= set(ACTIONS)
    for rule in rules.actions:
        region = next(r for r in SERIES_REGIONS if rule.action in series_actions(r))
        assert set(rule.descriptors) <= set(DESCRIPTORS[region])
