import numpy as np
import pytest

from mimeline.annotation.proposals import propose, read_proposals
from mimeline.vocabulary import ACTIONS, DESCRIPTORS, SERIES_REGIONS, resource, series_actions


@pytest.fixture(scope="module")
def rules():
    return read_proposals(resource("proposals.csv"))


def names(region, means, rules, rest=0.05):
    """Names proposed for clusters 1, 2, ... of these excesses; cluster 0 rests, half the time."""
    n = len(DESCRIPTORS[region])
    rows = np.array([[0.0] * n] * len(means) + means) + rest  # (2 len(means), n)
    clusters = np.repeat([0, *range(1, len(means) + 1)], [20 * len(means)] + [20] * len(means))
    return propose(region, np.repeat(rows, 20, axis=0), clusters, rules)


@pytest.mark.parametrize(
    ("region", "means", "expected"),
    [
        ("brow", [[0.5, 0, 0], [0, 0.4, 0.4], [0.1, 0, 0]], ["BrowDown", "BrowUp", "Neutral"]),
        ("eye", [[0.3, 0], [0, 0.3], [0.1, 0.1]], ["EyeSquint", "EyeWiden", "Neutral"]),
        (
            "mouth",
            [[0.3, 0, 0], [0.7, 0.2, 0], [0, 0, 0.3], [0, 0.6, 0]],
            ["SoftSmile", "Smile", "MouthFrown", "Neutral"],
        ),
    ],
)
def test_planted_means_get_the_name_of_their_action(rules, region, means, expected):
    found = names(region, means, rules)
    assert found == dict(enumerate(["Neutral", *expected]))


def test_the_stronger_of_two_actions_names_the_cluster(rules):
    assert names("brow", [[0.3, 0.5, 0.5]], rules)[1] == "BrowUp"
    assert names("brow", [[0.5, 0.3, 0.3]], rules)[1] == "BrowDown"


def test_half_of_an_actions_channels_are_half_of_its_strength(rules):
    assert names("brow", [[0, 0.25, 0]], rules)[1] == "Neutral"
    assert names("brow", [[0, 0.5, 0]], rules)[1] == "BrowUp"


def test_a_face_that_rests_high_is_still_at_rest(rules):
    assert names("brow", [[0, 0.4, 0.4]], rules, rest=0.3) == {0: "Neutral", 1: "BrowUp"}


def test_clusters_keep_their_own_numbers(rules):
    values = np.repeat([[0.0, 0.0], [0.5, 0.0]], 10, axis=0)
    found = propose("eye", values, np.repeat([7, 3], 10), rules)
    assert found == {3: "EyeSquint", 7: "Neutral"}


def test_the_resource_has_a_rule_for_each_action_that_clusters_may_bear(rules):
    wanted = {action for region in SERIES_REGIONS for action in series_actions(region)}
    assert {rule.action for rule in rules} == wanted <= set(ACTIONS)
    for rule in rules:
        region = next(r for r in SERIES_REGIONS if rule.action in series_actions(r))
        assert set(rule.descriptors) <= set(DESCRIPTORS[region])
