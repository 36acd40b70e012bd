import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.evaluation.labelling import (
    UNSURE,
    Naming,
    answers,
    curves,
    evaluate_labelling,
    names_f1,
    orders,
)
from mimeline.evaluation.sweep import best_f1
from mimeline.vocabulary import ACTIONS

NAMES = ("Neutral", "BrowUp", "BrowDown")
LENGTH = 20  # frames of a stretch of one class
STATES = np.array([0, 1, 0, 2, 0, 0, 1, 2, 0, 1])  # of the stretches of a clip


def frames_of(state, clip="a", **marks) -> pd.DataFrame:
    """A `frames` table: the brow by state (0, 1, 2), everything else absent."""
    state = np.asarray(state)
    table = pd.DataFrame({"clip_id": clip, "frame": np.arange(len(state))})
    marks = {"BrowUp": state == 1, "BrowDown": state == 2} | marks
    return table.assign(**dict.fromkeys(ACTIONS, False) | marks)


def intervals(*rows, region="brow", clip="a") -> pd.DataFrame:
    """`exemplars` rows given as (cluster, rank, start, end)."""
    table = pd.DataFrame(rows, columns=["cluster", "rank", "start_frame", "end_frame"])
    return table.assign(region=region, clip_id=clip, kind="random")


def labels_of(actions, confidence, share, region="brow") -> pd.DataFrame:
    table = pd.DataFrame({"action": actions, "confidence": confidence, "share": share})
    unmeasured = pd.Series([[]] * len(table), dtype=object)
    table = table.assign(region=region, cluster=range(len(table)), unmeasured=unmeasured)
    return table.assign(source="proposed", note=None, why=None)[tables.LABELS.schema.names]


def told(exemplars, truth, region="brow", **person) -> list[int]:
    return answers(exemplars, truth, region, **person)["answer"].tolist()


def test_an_interval_is_called_what_most_of_its_frames_are():
    truth = frames_of([0] * 10 + [1] * 10 + [2] * 10)
    shown = intervals((0, 0, 0, 10), (0, 1, 3, 13), (1, 0, 8, 20), (2, 0, 18, 30))
    assert told(shown, truth) == [0, 0, 1, 2]


def test_without_a_clear_majority_the_person_is_not_sure():
    truth = frames_of([0] * 10 + [1] * 10)
    shown = intervals((0, 0, 5, 15), (0, 1, 4, 14), (0, 2, 2, 12))
    assert told(shown, truth, clear=0.7) == [UNSURE, UNSURE, 0]
    assert told(shown, truth, clear=0.6) == [UNSURE, 0, 0]


def test_an_interval_that_truth_does_not_know_leaves_the_person_unsure():
    truth = frames_of([1] * 10)
    shown = pd.concat([intervals((0, 0, 0, 10)), intervals((0, 1, 0, 10), clip="b")])
    assert told(shown, truth) == [1, UNSURE]


def test_frames_whose_eye_is_closed_do_not_count_for_the_eye():
    squint, closed = np.arange(10) < 4, np.arange(10) >= 4
    truth = frames_of([0] * 10, EyeSquint=squint, EyeClose=closed)
    assert told(intervals((0, 0, 0, 10), region="eye"), truth, "eye") == [1]
    assert told(intervals((0, 0, 4, 10), region="eye"), truth, "eye") == [UNSURE]


def test_an_action_that_truth_does_not_measure_leaves_the_others_known():
    truth = frames_of([0] * 10 + [1] * 10, BrowDown=pd.array([pd.NA] * 20, dtype="boolean"))
    assert told(intervals((0, 0, 0, 10), (0, 1, 10, 20)), truth) == [0, 1]


def test_mistakes_are_as_frequent_as_said_and_repeat_for_a_seed():
    truth = frames_of([1] * 2000)
    shown = intervals(*[(0, rank, rank, rank + 5) for rank in range(1500)])
    first, again = (
        told(shown, truth, mistakes=0.1, rng=np.random.default_rng(3)) for _ in range(2)
    )
    assert first == again
    assert np.mean(np.array(first) != 1) == pytest.approx(0.1, abs=0.025)
    assert set(first) == {0, 1, 2}


STATE = np.repeat(np.tile(STATES, 12), LENGTH)
RUN = np.repeat(np.arange(len(STATES) * 12), LENGTH)


def seen(cluster: np.ndarray) -> pd.DataFrame:
    """Up to seven intervals of each cluster."""
    rows = []
    for number in np.unique(cluster):
        runs = np.unique(RUN[cluster == number])[:7]
        rows += [(number, rank, r * LENGTH, (r + 1) * LENGTH) for rank, r in enumerate(runs)]
    return intervals(*rows)


@pytest.fixture(scope="module")
def brow() -> tuple[pd.DataFrame, pd.DataFrame, pd.DataFrame]:
    """Truth, clusters and exemplars: six clusters of very different size, one of them mixed."""
    resting = np.where(RUN > 110, 5, np.where(RUN % 3 == 0, 0, 1))
    cluster = np.where(STATE == 0, resting, np.where(RUN % 4 < 3, STATE + 1, 4))
    truth = frames_of(STATE)
    clusters = truth[["clip_id", "frame"]].assign(cluster=cluster, margin=1.0)
    return truth, clusters, seen(cluster)


def naming(brow, actions, confidence, looks=5, **person) -> Naming:
    truth, clusters, shown = brow
    share = clusters["cluster"].value_counts(normalize=True).sort_index().to_numpy()
    labels = labels_of(actions, confidence, share)
    answered = answers(shown[shown["rank"] < looks], truth, "brow", **person)
    return Naming.of(clusters, labels, answered, truth, "brow")


WRONG = (["BrowUp", "Neutral", "BrowUp", "Neutral", "BrowUp", "Neutral"],
         [0.55, 0.99, 0.95, 0.6, 0.9, 0.97])  # fmt: skip


def test_a_person_who_never_errs_reaches_the_oracle_where_clusters_are_pure(brow):
    truth, clusters, _ = brow
    cluster = np.where(STATE == 0, clusters["cluster"] % 2, STATE + 1)
    pure = truth, clusters.assign(cluster=cluster), seen(cluster)
    found = naming(pure, *(facts[:4] for facts in WRONG))
    assert found.f1(np.zeros(4, dtype=int)) < 0.5
    assert found.f1(np.ones(4, dtype=int)) == 1


def test_before_any_look_clusters_bear_what_is_proposed(brow):
    found = naming(brow, *WRONG)
    assert [NAMES[code] for code in found.names[:, 0]] == WRONG[0]
    nothing = naming(brow, [None] * 6, [np.nan] * 6)
    assert nothing.f1(np.zeros(6, dtype=int)) == 0


def test_a_cluster_that_nobody_could_name_keeps_its_proposal():
    truth = frames_of([1, 0] * 20)
    clusters = truth[["clip_id", "frame"]].assign(cluster=0, margin=1.0)
    shown = intervals((0, 0, 0, 10), (0, 1, 10, 20))
    found = naming((truth, clusters, shown), ["BrowDown"], [0.9])
    assert found.names.tolist() == [[2, 2, 2]]
    assert found.gains[0, 1] == found.gains[0, 0]  # the second is worth as much as the first was


def test_one_long_interval_does_not_outvote_several_of_a_second():
    truth = frames_of([2] * 300 + [1] * 60)
    clusters = truth[["clip_id", "frame"]].assign(cluster=0, margin=1.0)
    shown = intervals((0, 0, 0, 300), (0, 1, 300, 330), (0, 2, 330, 360))
    found = naming((truth, clusters, shown), [None], [np.nan])
    assert found.names.tolist() == [[UNSURE, 2, 2, 1]]


def test_f1_of_names_is_that_of_the_best_names_for_votes():
    rng = np.random.default_rng(0)
    labels, codes = rng.integers(0, 5, 400), rng.integers(0, 3, 400)
    votes = np.zeros((5, 3), dtype=int)
    np.add.at(votes, (labels, codes), 1)
    assert names_f1(votes, votes.argmax(axis=1)) == pytest.approx(best_f1(labels, codes, "brow"))


def test_frames_without_a_name_are_missed():
    votes = np.array([[10, 0, 0], [0, 10, 0], [0, 10, 0]])
    assert names_f1(votes, np.array([0, 1, 1])) == 1
    assert names_f1(votes, np.array([0, 1, UNSURE])) == pytest.approx((1 + 2 * 10 / 30) / 2)


@pytest.mark.parametrize("start", [WRONG, ([None] * 6, [np.nan] * 6)])
def test_the_active_choice_needs_fewer_looks_than_a_random_one(brow, start):
    found = {"brow": naming(brow, *start)}
    total = int(found["brow"].looks.sum())
    ways = orders(found, 300, np.random.default_rng(0))

    def needed(way):
        f1 = curves(found, ways[way], np.arange(total + 1))["f1_brow"]  # (orders, total + 1)
        return (f1 < f1[:, -1:] - 0.01).sum(axis=1).mean()

    assert needed("active") < 0.6 * needed("random")


def test_every_order_ends_where_all_was_seen(brow):
    found = {"brow": naming(brow, *WRONG), "mouth": naming(brow, *WRONG, looks=2)}
    total = sum(int(one.looks.sum()) for one in found.values())
    for order in orders(found, 3, np.random.default_rng(0)).values():
        f1 = curves(found, order, np.array([0, total]))
        assert {len(own) for own in order} == {total}
        assert f1["f1_brow"][:, 1] == pytest.approx(found["brow"].f1(found["brow"].looks))
        assert f1["f1"] == pytest.approx((f1["f1_brow"] + f1["f1_mouth"]) / 2)


def test_in_turn_every_cluster_is_seen_once_before_any_is_seen_twice(brow):
    found = {"brow": naming(brow, *WRONG)}
    (order,) = orders(found, 1, np.random.default_rng(0))["in_turn"]
    assert order[:12].tolist() == [*range(6), *range(6)]


@pytest.fixture
def run(brow, tmp_path):
    truth, clusters, shown = brow

    def run(known=True, clip="a", seed=0, shown=shown):
        share = clusters["cluster"].value_counts(normalize=True).sort_index().to_numpy()
        (tmp_path / "truth").mkdir(exist_ok=True)
        told = truth.assign(clip_id=clip)
        tables.write(tables.FRAMES, told, tmp_path / "truth" / "frames.parquet")
        tables.write(tables.CLUSTERS, clusters, tmp_path / "brow.parquet")
        tables.write(tables.CLUSTERS, tables.empty(tables.CLUSTERS), tmp_path / "eye.parquet", "no")
        tables.write(tables.LABELS, labels_of(*WRONG, share), tmp_path / "labels.parquet")
        exemplars = shown[tables.EXEMPLARS.schema.names]
        tables.write(tables.EXEMPLARS, exemplars, tmp_path / "exemplars.parquet", "none")
        evaluate_labelling(
            [],
            [],
            {"brow": tmp_path / "brow.parquet", "eye": tmp_path / "eye.parquet"},
            tmp_path / "labels.parquet",
            tmp_path / "exemplars.parquet",
            tmp_path / "truth" if known else None,
            tmp_path / "metrics.parquet",
            looks=5,
            seed=seed,
        )
        found = tables.read(tables.METRICS, tmp_path / "metrics.parquet")
        return found, tables.reason(tmp_path / "metrics.parquet")

    return run


def test_the_curves_begin_at_the_proposals_and_end_at_the_person(run):
    found, reason = run()
    assert reason == ""
    assert set(found["metric"]) == {"f1", "f1_brow"}
    value = found.set_index(["variant", "metric", "n"])["value"]
    every = found["n"].max()
    for way in ("active", "random", "in_turn"):
        assert value[way, "f1_brow", 0] == value["proposed", "f1_brow", 0]
        assert value[way, "f1_brow", every] == pytest.approx(value["person", "f1_brow", every])
        assert value[f"{way}_unproposed", "f1_brow", 0] == 0
    assert value["proposed", "f1_brow", 0] < value["person", "f1_brow", every]
    assert value["person", "f1_brow", every] == value["person", "f1", every]


def test_only_the_random_orders_have_a_spread(run):
    found, _ = run()
    spread = found.dropna(subset=["low", "high"])
    assert set(spread["variant"]) == {"random", "random_unproposed"}
    assert (spread["low"] <= spread["value"] + 1e-12).all()
    assert (spread["value"] <= spread["high"] + 1e-12).all()


def test_the_table_repeats_for_a_seed(run):
    (first, _), (again, _), (other, _) = run(), run(), run(seed=1)
    pd.testing.assert_frame_equal(first, again)
    assert (first["value"] != other["value"]).any()


def test_without_truth_the_table_is_empty_and_tells_why(run):
    found, reason = run(known=False)
    assert found.empty
    assert reason == "no truth is known for these recordings"


def test_a_truth_of_other_clips_leaves_an_empty_table_that_tells_why(run):
    found, reason = run(clip="b")
    assert found.empty
    assert reason == "truth and clusters measure no frame in common"


def test_where_there_is_no_exemplar_the_table_is_empty(run, brow):
    found, reason = run(shown=brow[2].head(0))
    assert found.empty
    assert reason == "there are no exemplars"
