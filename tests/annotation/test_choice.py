import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.annotation.choice import choose

# clip, cluster, frames, margin and value of each run; cluster 0 has six intervals, 1 has one
RUNS = [
    ("a", 0, 4, 5.0, 0.1),
    ("a", 1, 6, 9.0, 2.0),
    ("a", 0, 5, 1.0, 0.6),
    ("b", 0, 9, 3.0, 0.3),
    ("c", 0, 2, 4.0, 0.25),
    ("d", 0, 8, 2.0, 0.2),
    ("e", 0, 5, 7.0, 0.5),
]


def clusters_of(runs) -> tuple[pd.DataFrame, np.ndarray]:
    """The `clusters` table of runs end to end, and a series of two channels."""
    rows = [(c, k, m, v) for c, k, length, m, v in runs for _ in range(length)]
    found = pd.DataFrame(rows, columns=["clip_id", "cluster", "margin", "value"])
    found = found.assign(frame=found.groupby("clip_id").cumcount())
    values = found["value"].to_numpy()[:, None] * [1.0, 2.0]
    return found[tables.CLUSTERS.schema.names], values


def chosen_of(runs, n_random=2, n_further=7, seed=0):
    return choose(*clusters_of(runs), n_random, n_further, np.random.default_rng(seed))


def intervals(chosen, cluster, *kinds):
    rows = chosen[(chosen["cluster"] == cluster) & chosen["kind"].isin(kinds)]
    return [tuple(row) for row in rows[["clip_id", "start_frame", "end_frame"]].to_numpy()]


ALL = ("medoid", "longest", "border", "random", "further")


def many(count=60):
    """Two clusters of intervals of many lengths and values, three to a clip."""
    return [(f"{i // 6:03d}", i % 2, 2 + i % 7, 1.0 + i, i * 37 % 61 / 60) for i in range(count)]


def test_each_kind_is_what_its_name_says():
    chosen = chosen_of(RUNS)
    # the mean over frames is 0.33; c lies near it too, but is short of the median length
    assert intervals(chosen, 0, "medoid") == [("b", 0, 9)]
    assert intervals(chosen, 0, "longest") == [("d", 0, 8)]  # of those that are left
    assert intervals(chosen, 0, "border") == [("a", 10, 15)]


def test_a_cluster_of_few_intervals_shows_each_of_them_once():
    chosen = chosen_of(RUNS)
    assert sorted(intervals(chosen, 0, *ALL)) == [
        ("a", 0, 4),
        ("a", 10, 15),
        ("b", 0, 9),
        ("c", 0, 2),
        ("d", 0, 8),
        ("e", 0, 5),
    ]
    assert intervals(chosen, 1, *ALL) == [("a", 4, 10)]


def test_a_cluster_of_enough_intervals_has_its_full_count_of_different_ones():
    chosen = chosen_of(many())
    for cluster in (0, 1):
        shown = intervals(chosen, cluster, *ALL)
        assert len(shown) == len(set(shown)) == 3 + 2 + 7
        kinds = chosen.loc[chosen["cluster"] == cluster].sort_values("rank")["kind"].tolist()
        assert kinds == ["medoid", "longest", "border", *["random"] * 2, *["further"] * 7]


def test_the_first_further_exemplar_shows_the_part_that_none_showed():
    """Of 40 intervals, five of one clip lie elsewhere; the medoid and the longest do not."""
    common = [(f"a{i:02d}", 0, 12, 5.0, 0.1 + i / 1000) for i in range(35)]
    rare = [(f"r{i}", 0, 8, 9.0, 0.8) for i in range(5)]
    chosen = chosen_of([*common, *rare], n_random=0)
    assert not {clip[0] for clip, _, _ in intervals(chosen, 0, "medoid", "border")} & {"r"}
    assert intervals(chosen, 0, "further")[0][0].startswith("r")
    assert not intervals(chosen, 0, "further")[1][0].startswith("r")


def test_an_interval_that_rises_is_not_told_by_one_that_stays_at_its_mean():
    still = [(f"a{i:02d}", 0, 10, 5.0, 0.5) for i in range(30)]
    clusters, values = clusters_of([*still, ("z", 0, 10, 9.0, 0.5)])
    values[-10:] *= np.linspace(0, 2, 10)[:, None]
    chosen = choose(clusters, values, 0, 1, np.random.default_rng(0))
    assert intervals(chosen, 0, "further") == [("z", 0, 10)]


def test_further_exemplars_come_from_clips_that_were_not_shown():
    runs = [(f"c{i % 12:02d}", i // 12 % 2, 5, 1.0 + i, i * 7 % 48 / 48) for i in range(48)]
    chosen = chosen_of(sorted(runs))
    clips = [clip for clip, _, _ in intervals(chosen, 0, *ALL)]
    assert len(set(clips[5:])) == 7 and not set(clips[5:]) & set(clips[:5])


def test_exemplars_repeat_for_a_seed_and_change_with_it():
    pd.testing.assert_frame_equal(chosen_of(many(), seed=1), chosen_of(many(), seed=1))
    one, two = chosen_of(many(), seed=1), chosen_of(many(), seed=2)
    assert intervals(one, 0, "random") != intervals(two, 0, "random")
    assert intervals(one, 0, "medoid") == intervals(two, 0, "medoid")


@pytest.mark.parametrize("channels", [1, 3])
def test_intervals_of_one_frame_and_channels_that_never_move_are_fine(channels):
    runs = [(f"{i:02d}", 0, 1, 1.0, 0.5) for i in range(20)]
    clusters, values = clusters_of(runs)
    chosen = choose(clusters, np.repeat(values[:, :1], channels, 1), 2, 7, np.random.default_rng(0))
    assert len(set(intervals(chosen, 0, *ALL))) == 12


def test_no_random_and_no_further_exemplars_may_be_asked_for():
    assert set(chosen_of(RUNS, 0, 0)["kind"]) == {"medoid", "longest", "border"}


def test_the_table_of_a_region_keeps_its_contract(tmp_path):
    chosen = chosen_of(many())
    tables.write(tables.EXEMPLARS, chosen.assign(region="brow"), tmp_path / "exemplars.parquet")
    assert len(tables.read(tables.EXEMPLARS, tmp_path / "exemplars.parquet")) == len(chosen)


def test_no_cluster_gives_no_exemplar():
    none = tables.empty(tables.CLUSTERS)
    assert choose(none, np.empty((0, 2)), 3, 2, np.random.default_rng(0)).empty
