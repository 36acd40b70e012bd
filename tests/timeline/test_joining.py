from dataclasses import replace
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mimeline.errors import BadFile
from mimeline.timeline.joining import Cost, cost, merge
from mimeline.timeline.timeline import Interval, Timeline

from .test_comparison import timeline, timelines

EMPTY = timeline(n_frames=40)


@given(timelines())
def test_merged_with_nothing_a_timeline_stays(a):
    assert merge(a, EMPTY) == merge(EMPTY, a) == a


@given(timelines())
def test_merged_with_itself_a_timeline_stays(a):
    assert merge(a, a) == a == merge(a, a, "second")


@given(timelines(), st.integers(0, 40))
def test_the_halves_of_a_timeline_make_the_whole(whole, cut):
    def apart(interval):  # one that ends at the cut is not cut there
        return cut not in (interval.start, interval.end)

    whole = with_intervals(whole, [i for i in whole if apart(i)])
    first = [replace(i, end=min(i.end, cut)) for i in whole if i.start < cut]
    second = [replace(i, start=max(i.start, cut)) for i in whole if i.end > cut]
    halves = with_intervals(whole, first), with_intervals(whole, second)
    assert merge(*halves) == merge(*reversed(halves)) == whole


@given(timelines(), timelines(), st.sampled_from(["first", "second"]))
def test_the_preferred_timeline_stands_whole(a, b, prefer):
    merged = merge(a, b, prefer)
    assert set(merged.tracks) == {*a.tracks, *b.tracks}
    for interval in a if prefer == "first" else b:
        assert any(holds(other, interval) for other in merged.tracks[interval.track])


def test_an_action_that_goes_on_in_the_other_timeline_is_one():
    a = timeline(mouth=[Interval("Smile", 10, 30), Interval("Smile", 50, 60)])
    for start, end in ((30, 50), (20, 55)):
        b = timeline(mouth=[Interval("Smile", start, end)])
        assert merge(a, b) == merge(b, a) == timeline(mouth=[Interval("Smile", 10, 60)])


def test_what_merging_costs_is_counted():
    a = timeline(mouth=[Interval("Smile", 10, 30), Interval("Smile", 50, 60)])
    b = timeline(
        mouth=[Interval("Smile", 20, 40), Interval("MouthFrown", 56, 70)],
        brow=[Interval("BrowUp", 10, 30)],
    )
    assert cost(a, b, merge(a, b, "first")) == Cost(joined=1, cut=1, left_out=0)
    c = timeline(mouth=[Interval("MouthFrown", 52, 62)])
    assert cost(a, c, merge(a, c, "first")) == Cost(joined=0, cut=0, left_out=1)
    assert cost(a, a, merge(a, a)) == Cost(0, 0, 0)


def test_actions_that_touch_within_one_timeline_stay_two():
    a = timeline(mouth=[Interval("Smile", 10, 30), Interval("Smile", 30, 60)])
    assert merge(a, timeline(mouth=[Interval("Smile", 80, 90)])).tracks["mouth"][:2] == (
        Interval("Smile", 10, 30),
        Interval("Smile", 30, 60),
    )


def test_actions_that_touch_stay_two_where_both_timelines_part_them():
    a = timeline(mouth=[Interval("Smile", 10, 30), Interval("Smile", 30, 60)])
    b = timeline(mouth=[Interval("Smile", 10, 30, None, "ticc", 3, 0.9)])
    assert [(i.start, i.end) for i in merge(a, b)] == [(10, 30), (30, 60)]


def test_what_the_parts_tell_differently_of_their_origin_is_left_out():
    found = Interval("Smile", 10, 30, None, "ticc", 3, 0.9)
    person = Interval("Smile", 20, 40)
    merged = merge(timeline(mouth=[found]), timeline(mouth=[person]))
    assert merged == timeline(mouth=[Interval("Smile", 10, 40, None, "human")])
    alike = merge(timeline(mouth=[found]), timeline(mouth=[replace(found, start=25, end=40)]))
    assert alike == timeline(mouth=[replace(found, end=40)])


def test_conflicts_are_named_with_frames_and_times_and_the_way_out():
    a = timeline(mouth=[Interval("Smile", 30, 60)], brow=[Interval("BrowUp", 0, 9)])
    b = timeline(mouth=[Interval("SoftSmile", 45, 90)], brow=[Interval("BrowUp", 3, 9, "left")])
    with pytest.raises(BadFile) as error:
        merge(a, b)
    text = str(error.value)
    assert "Smile against SoftSmile on mouth in frames 45 to 60 (1.50 to 2.00 s)" in text
    assert "BrowUp against BrowUp left on brow" in text and "--prefer first" in text


def test_of_many_conflicts_three_are_named_and_the_rest_counted():
    a = timeline(mouth=[Interval("Smile", n, n + 5) for n in range(0, 50, 10)])
    b = timeline(mouth=[Interval("SoftSmile", n, n + 5) for n in range(0, 50, 10)])
    with pytest.raises(BadFile, match="and 2 more"):
        merge(a, b)


def test_the_other_timeline_loses_the_frames_in_conflict():
    a = timeline(mouth=[Interval("Smile", 30, 60)])
    b = timeline(mouth=[Interval("SoftSmile", 45, 90)])
    assert merge(a, b, "first").tracks["mouth"] == (
        Interval("Smile", 30, 60),
        Interval("SoftSmile", 60, 90),
    )
    assert merge(a, b, "second").tracks["mouth"] == (
        Interval("Smile", 30, 45),
        Interval("SoftSmile", 45, 90),
    )


def test_what_has_lost_most_of_its_frames_goes_and_leaves_no_slivers():
    a = timeline(mouth=[Interval("Smile", 10, 50)])
    b = timeline(mouth=[Interval("SoftSmile", 9, 51)])
    assert merge(a, b, "first") == a and merge(a, b, "second") == b


def test_left_and_right_do_not_conflict():
    a = timeline(brow=[Interval("BrowUp", 0, 9, "left")])
    b = timeline(brow=[Interval("BrowDown", 3, 12, "right")])
    assert len(merge(a, b).tracks["brow"]) == 2


@pytest.mark.parametrize(
    "other",
    [timeline(fps=25), timeline(n_frames=99), Timeline("another", Fraction(30), 100, {})],
)
def test_timelines_of_other_clips_are_refused(other):
    with pytest.raises(BadFile, match="in the first timeline and"):
        merge(timeline(), other)


def with_intervals(whole: Timeline, intervals) -> Timeline:
    tracks = {track: [i for i in intervals if i.track == track] for track in whole.tracks}
    return replace(whole, tracks=tracks)


def holds(outer: Interval, inner: Interval) -> bool:
    same = (outer.action, outer.side) == (inner.action, inner.side)
    return same and outer.start <= inner.start and inner.end <= outer.end
