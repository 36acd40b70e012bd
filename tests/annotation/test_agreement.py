import numpy as np
import pandas as pd
import pytest
from sklearn.metrics import cohen_kappa_score

from mimeline.annotation.agreement import agreement
from mimeline.annotation.label_file import Answer, RegionAnswers

ACTIONS = {"brow": ["Neutral", "BrowUp", "BrowDown"], "mouth": ["Neutral", "Smile", "SoftSmile"]}


def labels_of(n, regions=("brow",)):
    rng = np.random.default_rng(3)
    rows = [(r, k, s) for r in regions for k, s in enumerate(rng.dirichlet(np.ones(n)))]
    return pd.DataFrame(rows, columns=["region", "cluster", "share"])


def brow(**names):
    clusters = {int(k[1:]): v if isinstance(v, Answer) else Answer(v) for k, v in names.items()}
    return {"brow": RegionAnswers("f", clusters)}


def test_kappa_is_that_of_scikit_learn_over_clusters_and_over_frames():
    rng = np.random.default_rng(0)
    persons = [
        {r: [names[i] for i in rng.integers(0, 3, 12)] for r, names in ACTIONS.items()}
        for _ in range(2)
    ]
    persons[1]["brow"][:6] = persons[0]["brow"][:6]
    one, other = (
        {r: RegionAnswers("f", dict(enumerate(map(Answer, n)))) for r, n in person.items()}
        for person in persons
    )
    labels = labels_of(12, ACTIONS)
    flat = [person["brow"] + person["mouth"] for person in persons]
    found = agreement(one, other, labels)
    assert found.kappa == pytest.approx(cohen_kappa_score(*flat))
    assert found.kappa_frames == pytest.approx(
        cohen_kappa_score(*flat, sample_weight=labels["share"])
    )
    assert found.n == 24
    assert found.same == np.mean(np.array(flat[0]) == np.array(flat[1]))
    assert len(found.differing) == round(24 * (1 - found.same))


def test_who_agrees_on_several_names_has_kappa_one():
    one = brow(_0="BrowUp", _1="Neutral", _2="BrowDown")
    found = agreement(one, one, labels_of(3))
    assert (found.kappa, found.kappa_frames, found.same) == (1, pytest.approx(1), 1)
    assert found.differing == ()


def test_where_both_gave_one_name_to_everything_kappa_is_not_defined():
    one = brow(_0="Neutral", _1="Neutral")
    found = agreement(one, one, labels_of(2))
    assert np.isnan(found.kappa)
    assert np.isnan(found.kappa_frames)
    assert (found.same, found.n) == (1, 2)


def test_only_clusters_that_both_named_count():
    one = brow(_0="BrowUp", _1=Answer(), _2="Neutral", _3="BrowDown")
    other = brow(_0="BrowUp", _1="Neutral", _2=Answer(), _4="BrowDown")
    found = agreement(one, other, labels_of(5))
    assert (found.n, found.same) == (1, 1)


def test_nothing_in_common_has_no_kappa():
    found = agreement(brow(_0="BrowUp"), {}, labels_of(2))
    assert np.isnan([found.kappa, found.kappa_frames, found.same]).all()
    assert found.n == 0


def test_merged_clusters_have_the_name_of_the_one_they_are_the_same_as():
    one = brow(_0="BrowUp", _1=Answer(same_as=0), _2=Answer(same_as=1), _3="Neutral")
    other = brow(_0="BrowUp", _1="BrowUp", _2="BrowDown", _3=Answer(same_as=4))
    found = agreement(one, other, labels_of(5))
    assert found.n == 3
    assert found.differing == (("brow", 2),)


def test_a_finer_note_is_no_other_name():
    found = agreement(brow(_0=Answer("BrowUp", "strong")), brow(_0="BrowUp"), labels_of(1))
    assert found.same == 1


def test_names_of_different_fits_are_not_compared():
    other = {"brow": RegionAnswers("g", {0: Answer("BrowUp")})}
    assert agreement(brow(_0="BrowUp"), other, labels_of(1)).n == 0
