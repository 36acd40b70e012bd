import numpy as np
import pandas as pd
import pytest

from mimeline.annotation.queries import after, chances, classes, worth, wrong


def rows(*clusters, region="brow") -> pd.DataFrame:
    """The `labels` of clusters given as (action, confidence, source, share)."""
    table = pd.DataFrame(clusters, columns=["action", "confidence", "source", "share"])
    return table.assign(region=region, cluster=range(len(table)))


def test_the_less_sure_a_proposal_the_more_an_answer_is_worth():
    labels = rows(*[("BrowUp", sure, "proposed", 0.25) for sure in (1.0, 0.9, 0.6, None)])
    assert (np.diff(worth(labels)) > 0).all()


def test_of_two_proposals_as_sure_the_larger_cluster_comes_first():
    labels = rows(("BrowUp", 0.8, "proposed", 0.1), ("Neutral", 0.8, "moved", 0.3))
    small, large = worth(labels)
    assert large == pytest.approx(3 * small)


def test_a_large_cluster_is_worth_a_look_however_sure_its_proposal_is():
    labels = rows(("Neutral", 1.0, "proposed", 0.5), ("BrowUp", 0.6, "proposed", 0.02))
    large, small = worth(labels)
    assert large > small


def test_what_a_person_named_is_worth_no_look_and_what_they_could_not_name_is():
    labels = rows(
        ("BrowUp", None, "human", 0.4), (None, None, "human", 0.3), (None, None, "proposed", 0.3)
    )
    named, unsure, nothing = worth(labels)
    assert named == 0
    assert unsure == nothing > 0


def test_regions_are_judged_apart_in_the_order_of_their_rows():
    brow = rows(("BrowUp", 0.7, "proposed", 0.5), (None, None, "proposed", 0.5))
    mouth = rows(("Smile", 0.7, "proposed", 0.5), (None, None, "proposed", 0.5), region="mouth")
    mixed = pd.concat([mouth.iloc[:1], brow, mouth.iloc[1:]], ignore_index=True)
    apart = worth(mouth)[0], *worth(brow), worth(mouth)[1]
    assert worth(mixed) == pytest.approx(apart)


def test_labels_of_no_cluster_are_worth_nothing():
    assert len(worth(rows())) == 0


def test_chances_add_up_and_the_proposed_name_has_the_best():
    labels = rows(("Smile", 0.9, "proposed", 0.5), (None, None, "proposed", 0.5), region="mouth")
    chance = chances(labels, "mouth")
    assert chance.sum(axis=1) == pytest.approx(1)
    assert classes("mouth")[chance[0].argmax()] == "Smile"
    assert chance[1] == pytest.approx(1 / len(classes("mouth")))


def test_an_answer_that_agrees_leaves_less_to_ask_than_one_that_does_not():
    (chance,) = chances(rows(("BrowUp", 0.9, "proposed", 1.0)), "brow")
    up, down = classes("brow").index("BrowUp"), classes("brow").index("BrowDown")
    agreed, contradicted = after(chance, up), after(chance, down)
    assert wrong(agreed) < wrong(contradicted)
    assert wrong(agreed) < wrong(chance)
    assert after(contradicted, down).argmax() == down
    assert wrong(after(contradicted, down)) < wrong(contradicted)


def test_not_sure_leaves_everything_to_ask():
    (chance,) = chances(rows(("BrowUp", 0.7, "proposed", 1.0)), "brow")
    assert after(chance, -1) == pytest.approx(chance)
