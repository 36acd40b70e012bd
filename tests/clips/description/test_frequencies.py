import numpy as np
import pandas as pd
import pytest

from mimeline.clips.description.frequencies import MOST, evened, frequencies

COLUMNS = ["clip_id", "kind", "attribute", "seconds"]


def one_action_each(counts):
    """So many clips of each action, one action a clip."""
    names = [name for name, count in counts.items() for _ in range(count)]
    ids = [f"clip{number:03}" for number in range(len(names))]
    rows = [(clip_id, "action", name, 1.0) for clip_id, name in zip(ids, names, strict=True)]
    return ids, pd.DataFrame(rows, columns=COLUMNS)


def weighted(ids, shown, balance):
    """Each attribute's share of all weight."""
    table = evened(ids, shown, balance)
    joined = shown.merge(table, on="clip_id")
    return table["weight"], joined.groupby("attribute")["weight"].sum() / table["weight"].sum()


def test_without_balance_all_clips_count_the_same():
    ids, shown = one_action_each({"talk": 80, "smile": 15, "wink": 5})
    assert (evened(ids, shown, 0.0)["weight"] == 1).all()


def test_full_balance_makes_actions_that_do_not_meet_count_the_same():
    ids, shown = one_action_each({"talk": 80, "smile": 15, "wink": 5})
    weight, share = weighted(ids, shown, 1.0)
    assert share.to_numpy() == pytest.approx(np.full(3, 1 / 3))
    assert weight.mean() == pytest.approx(1)


def test_half_balance_goes_half_the_way():
    ids, shown = one_action_each({"talk": 80, "smile": 20})
    _, share = weighted(ids, shown, 0.5)
    assert share["talk"] / share["smile"] == pytest.approx(2)


def test_actions_that_meet_come_closer():
    ids, shown = one_action_each({"talk": 60, "smile": 30, "wink": 10})
    also = pd.DataFrame([(i, "action", "talk", 1.0) for i in ids[80:]], columns=COLUMNS)
    shown = pd.concat([shown, also])
    before, after = (weighted(ids, shown, balance)[1] for balance in (0.0, 1.0))
    assert before["talk"] / before["wink"] == pytest.approx(8)
    assert after["talk"] / after["wink"] < 3


def test_no_clip_counts_much_more_than_another():
    ids, shown = one_action_each({"talk": 999, "wink": 1})
    weight = evened(ids, shown, 1.0)["weight"]
    assert weight.max() / weight.min() == pytest.approx(MOST)
    assert weight.mean() == pytest.approx(1)


def test_hair_and_light_weigh_nothing():
    ids, shown = one_action_each({"talk": 9, "smile": 1})
    hat = pd.DataFrame([(ids[0], "attribute", "wearing_hat", None)], columns=COLUMNS)
    pd.testing.assert_frame_equal(
        evened(ids, pd.concat([shown, hat]), 1.0), evened(ids, shown, 1.0)
    )


def test_a_clip_that_shows_nothing_counts_like_the_commonest():
    ids, shown = one_action_each({"talk": 9, "smile": 1})
    weight = evened([*ids, "still"], shown, 1.0).set_index("clip_id")["weight"]
    assert weight["still"] == weight["clip000"]


def test_no_clip_at_all_has_no_weight():
    nothing = pd.DataFrame([], columns=COLUMNS)
    assert evened([], nothing, 0.5).empty
    assert (evened(["a", "b"], nothing, 0.5)["weight"] == 1).all()


def test_attributes_are_counted_by_clip_and_by_second():
    shown = pd.DataFrame(
        [
            ("a", "action", "smile", 2.0),
            ("a", "action", "smile", 1.5),
            ("b", "action", "smile", 1.0),
            ("b", "emotion", "smile", 4.0),
            ("b", "attribute", "male", None),
        ],
        columns=COLUMNS,
    )
    table = frequencies(shown, n_clips=4).set_index(["kind", "attribute"])
    assert table.loc[("action", "smile")].tolist() == [2, 0.5, 4.5]
    assert table.loc[("emotion", "smile")].tolist() == [1, 0.25, 4.0]
    assert table.loc[("attribute", "male"), "clips"] == 1
    assert np.isnan(table.loc[("attribute", "male"), "seconds"])
