from hypothesis import given
from hypothesis import strategies as st

from mimeline.clips.catalogues.annotations import match

some = st.text("ab-_0123456789", min_size=1, max_size=6)


@given(st.lists(some, max_size=8), st.lists(some, unique=True, max_size=8), st.randoms())
def test_no_annotations_are_of_two_clips_and_order_does_not_matter(names, keys, random):
    starts = [float(n) for n in range(len(names))]
    found, doubts = match(names, starts, keys)
    taken = [key for key in found if key is not None]
    assert len(taken) == len(set(taken))
    assert set(taken) <= set(keys)
    assert not any(doubt and key is not None for doubt, key in zip(doubts, found, strict=True))
    shuffled = random.sample(range(len(names)), len(names))
    again, _ = match(
        [names[n] for n in shuffled],
        [starts[n] for n in shuffled],
        random.sample(keys, len(keys)),
    )
    assert again == [found[n] for n in shuffled]


@given(st.lists(some, unique=True, max_size=8))
def test_equal_names_always_find_each_other(names):
    found, doubts = match(names, [0.0] * len(names), reversed(names))
    assert found == names
    assert not any(doubts)


def test_where_nothing_fits_nothing_is_in_doubt():
    assert match(["a_0"], [0.0], ["b_0", "a_1"]) == ([None], [False])


def test_more_annotations_than_clips_of_a_name_leave_both_in_doubt():
    found, doubts = match(["a_35", "a_35"], [1.0, 2.0], ["a_35_2", "a_35_4", "a_35_5"])
    assert (found, doubts) == ([None, None], [True, True])
