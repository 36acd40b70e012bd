import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.annotation.exemplars import choose, cluster_runs

# clip, cluster, frames, margin and value of each run; cluster 0 has four intervals, 1 has one
RUNS = [
    ("a", 0, 4, 5.0, 0.1),
    ("a", 1, 6, 9.0, 2.0),
    ("a", 0, 5, 1.0, 0.6),
    ("b", 0, 9, 3.0, 0.3),
    ("c", 0, 2, 4.0, 0.25),
]


def clusters_of(runs) -> tuple[pd.DataFrame, np.ndarray]:
    """The `clusters` table of runs end to end, and a series of two channels."""
    rows = [(c, k, m, v) for c, k, length, m, v in runs for _ in range(length)]
    found = pd.DataFrame(rows, columns=["clip_id", "cluster", "margin", "value"])
    found = found.assign(frame=found.groupby("clip_id").cumcount())
    values = found["value"].to_numpy()[:, None] * [1.0, 2.0]
    return found[tables.CLUSTERS.schema.names], values


def picked(chosen, cluster, kind):
    rows = chosen[(chosen["cluster"] == cluster) & (chosen["kind"] == kind)]
    return [tuple(row) for row in rows[["clip_id", "start_frame", "end_frame"]].to_numpy()]


@pytest.fixture
def chosen():
    return choose(*clusters_of(RUNS), 2, np.random.default_rng(0))


def test_intervals_are_half_open_and_never_reach_over_a_clip_or_a_gap():
    clusters, _ = clusters_of([*RUNS, ("d", 0, 4, 2.0, 0.0)])
    clusters = clusters[~((clusters["clip_id"] == "b") & (clusters["frame"] == 3))]
    runs = cluster_runs(clusters)
    keys = ["clip_id", "cluster", "start_frame", "end_frame"]
    assert runs[keys].to_numpy().tolist() == [
        ["a", 0, 0, 4],
        ["a", 1, 4, 10],
        ["a", 0, 10, 15],
        ["b", 0, 0, 3],
        ["b", 0, 4, 9],
        ["c", 0, 0, 2],
        ["d", 0, 0, 4],
    ]
    assert runs["margin"].tolist() == pytest.approx([5, 9, 1, 3, 3, 4, 2])


def test_each_kind_is_what_its_name_says(chosen):
    assert picked(chosen, 0, "longest") == [("b", 0, 9)]
    assert picked(chosen, 0, "border") == [("a", 10, 15)]
    # the mean over frames is 0.33; c lies near it too, but is short of the median length
    assert picked(chosen, 0, "medoid") == [("b", 0, 9)]
    assert len(picked(chosen, 0, "random")) == 2


def test_random_exemplars_are_different_intervals_of_the_cluster(chosen):
    own = {("a", 0, 4), ("a", 10, 15), ("b", 0, 9), ("c", 0, 2)}
    random = picked(chosen, 0, "random")
    assert set(random) <= own
    assert len(set(random)) == 2


def test_a_cluster_of_one_interval_shows_it_for_every_kind(chosen):
    kinds = chosen.loc[chosen["cluster"] == 1, "kind"].tolist()
    assert sorted(kinds) == ["border", "longest", "medoid", "random"]
    assert all(picked(chosen, 1, kind) == [("a", 4, 10)] for kind in kinds)


def test_exemplars_repeat_for_a_seed_and_change_with_it():
    many = [("abc"[i // 20], i % 2, 2 + i % 7, 1.0 + i, i / 60) for i in range(60)]

    def drawn(seed):
        return choose(*clusters_of(many), 5, np.random.default_rng(seed))

    pd.testing.assert_frame_equal(drawn(1), drawn(1))
    assert picked(drawn(1), 0, "random") != picked(drawn(2), 0, "random")
    assert picked(drawn(1), 0, "medoid") == picked(drawn(2), 0, "medoid")


def test_no_random_exemplars_may_be_asked_for():
    chosen = choose(*clusters_of(RUNS), 0, np.random.default_rng(0))
    assert set(chosen["kind"]) == {"medoid", "longest", "border"}


def test_the_table_of_a_region_keeps_its_contract(chosen, tmp_path):
    tables.write(tables.EXEMPLARS, chosen.assign(region="brow"), tmp_path / "exemplars.parquet")
    rows = tables.read(tables.EXEMPLARS, tmp_path / "exemplars.parquet")
    assert set(rows["region"]) == {"brow"}
    assert len(rows) == len(chosen)


def test_no_cluster_gives_no_exemplar():
    none = tables.empty(tables.CLUSTERS)
    chosen = choose(none, np.empty((0, 2)), 3, np.random.default_rng(0))
    assert chosen.empty
