import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.annotation.profiles import profiles
from mimeline.annotation.proposals import read_rules
from mimeline.annotation.region_model import RegionModel
from mimeline.annotation.series import sequences
from mimeline.ticc import TICC
from mimeline.toy import simulate
from mimeline.vocabulary import resource, series_actions, series_channels

REGION = "eye"


@pytest.fixture(scope="module")
def rules():
    return read_rules(resource("proposals.csv"))


@pytest.fixture(scope="module")
def world():
    """The eye of a small toy world: frames with truth in `name`, and its channels' values."""
    toy = simulate(20, 30, seed=1)
    channels = series_channels(REGION, "left")
    frames = toy.motion[["clip_id", "frame", *channels]]
    actions = list(series_actions(REGION))
    name = np.array(["Neutral", *actions], dtype=object)
    truth = toy.frames[actions].to_numpy() @ np.arange(1, len(actions) + 1)
    return frames.assign(name=name[truth]), frames[list(channels)].to_numpy("float64"), channels


@pytest.fixture(scope="module")
def fit(world):
    frames, values, channels = world

    def fit(n_clusters):
        ticc = TICC(n_clusters, max_iter=10).fit(values, sequences(frames)[1])
        model = RegionModel(ticc, channels)
        return model, model.decode(frames)

    return fit


@pytest.fixture(scope="module")
def eight(fit):
    return fit(8)


@pytest.fixture(scope="module")
def facts(eight, world, rules):
    model, clusters = eight
    return profiles(REGION, clusters, world[1], model, rules).set_index("cluster", drop=False)


def names_of(clusters, world):
    return world[0]["name"].groupby(clusters["cluster"].to_numpy())


def test_sizes_count_frames_intervals_and_clips(facts, eight):
    _, clusters = eight
    rows = clusters.groupby("cluster")
    assert facts["n_frames"].to_dict() == rows.size().to_dict()
    assert facts["n_clips"].to_dict() == rows["clip_id"].nunique().to_dict()
    assert (facts["n_intervals"] >= facts["n_clips"]).all()
    assert facts["median_frames"].between(1, 300).all()


def test_variants_of_one_action_are_each_others_nearest(facts, eight, world):
    """Squints, moderate and strong, lie nearer to each other than to any widening."""
    name = names_of(eight[1], world).agg(lambda own: own.mode()[0])
    assert name.value_counts().min() >= 2
    assert (name[facts["nearest"]].to_numpy() == name.to_numpy()).mean() >= 7 / 8
    assert (facts["distance"] > 0).all()


def test_the_distance_is_what_the_nearest_cluster_costs_more(facts, eight, world):
    model, clusters = eight
    ids = clusters["cluster"].to_numpy()
    costs = model.ticc.mean_costs(world[1], ids, sequences(clusters)[1])
    for row in facts.itertuples():
        others = np.delete(costs[row.cluster], row.cluster)
        assert row.distance == pytest.approx(others.min() - costs[row.cluster, row.cluster])


def test_purity_is_near_to_the_truth(facts, eight, world):
    true = names_of(eight[1], world).agg(lambda own: own.value_counts(normalize=True).max())
    assert (facts["purity"] - true).abs().max() < 0.15


def test_a_cluster_of_all_is_hardly_pure(fit, world, rules):
    """One cluster: more than the rest's share of its frames, and no other cluster to be near."""
    model, clusters = fit(1)
    row = profiles(REGION, clusters, world[1], model, rules).iloc[0]
    share = (world[0]["name"] == "Neutral").mean()
    assert row["purity"] == pytest.approx(share, abs=0.1)
    assert pd.isna(row["nearest"]) and pd.isna(row["distance"])


def test_where_no_action_is_measured_purity_is_unknown(rules):
    rng = np.random.default_rng(0)
    values = np.repeat(rng.random((30, 1)) > 0.5, 20, axis=0) + 0.1 * rng.normal(size=(600, 1))
    model = RegionModel(TICC(2).fit(values), ("mouthStretchLeft",))
    frames = pd.DataFrame({"clip_id": "a", "frame": range(600), "mouthStretchLeft": values[:, 0]})
    found = profiles("mouth", model.decode(frames), values, model, rules)
    assert found["purity"].isna().all() and found["distance"].notna().all()


def test_the_rows_keep_the_tables_contract(facts, fit, world, rules, tmp_path):
    model, clusters = fit(1)
    for rows in (facts.reset_index(drop=True), profiles(REGION, clusters, world[1], model, rules)):
        tables.write(tables.PROFILES, rows, tmp_path / "profiles.parquet")
        assert len(tables.read(tables.PROFILES, tmp_path / "profiles.parquet")) == len(rows)
