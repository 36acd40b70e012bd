from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sklearn.metrics import cohen_kappa_score

from mimeline.errors import BadFile
from mimeline.timeline.comparison import classes, diff
from mimeline.timeline.timeline import Interval, Timeline
from mimeline.vocabulary import TRACKS, track_actions


def timeline(fps=30, n_frames=100, **tracks) -> Timeline:
    return Timeline("clip", Fraction(fps), n_frames, tracks)


@st.composite
def timelines(draw, n_frames=40):
    """Timelines of a clip: some tracks, on each of them actions of both sides or of one."""
    tracks = {}
    for track in draw(st.lists(st.sampled_from(TRACKS), unique=True, max_size=4)):
        halves = draw(st.sampled_from([(None,), ("left",), ("left", "right")]))
        tracks[track] = [i for side in halves for i in draw(intervals(track, side, n_frames))]
    return Timeline("clip", Fraction(30), n_frames, tracks)


@st.composite
def intervals(draw, track, side, n_frames):
    edges = sorted(draw(st.sets(st.integers(0, n_frames), max_size=8)))
    spans = [span for span in pairwise(edges) if draw(st.booleans())]
    action = st.sampled_from(track_actions(track))
    return [Interval(draw(action), start, end, side) for start, end in spans]


@given(timelines())
def test_a_timeline_does_not_differ_from_itself(a):
    found = diff(a, a)
    assert not found and found.changes == ()
    assert {agreement.share for agreement in found.agreement.values()} <= {1.0}


@given(timelines(), timelines())
def test_seen_from_the_other_side_differences_are_the_same_the_other_way_round(a, b):
    there, back = diff(a, b), diff(b, a)
    assert bool(there) == bool(back) == (a != b)
    assert (there.only_a, there.only_b) == (back.only_b, back.only_a)
    assert there.agreement == pytest.approx(back.agreement)
    assert {change.track for change in there.changes} == {change.track for change in back.changes}


@given(timelines(), timelines())
def test_every_interval_that_is_not_in_both_is_told_of_once(a, b):
    found = diff(a, b)
    for track in found.agreement:
        one, other = set(a.tracks[track]), set(b.tracks[track])
        changes = [change for change in found.changes if change.track == track]
        assert sorted(map(repr, one - other)) == sorted(repr(c.a) for c in changes if c.a)
        assert sorted(map(repr, other - one)) == sorted(repr(c.b) for c in changes if c.b)


def test_a_shifted_action_is_moved_by_frames_at_each_end():
    a = timeline(mouth=[Interval("Smile", 10, 50)])
    b = timeline(mouth=[Interval("Smile", 12, 45)])
    (change,) = diff(a, b).changes
    assert (change.kind, change.track, change.shift) == ("moved", "mouth", (2, -5))


def test_another_action_at_its_place_is_told_as_one_difference():
    a = timeline(mouth=[Interval("Smile", 10, 50)])
    b = timeline(mouth=[Interval("SoftSmile", 11, 50)])
    (change,) = diff(a, b).changes
    assert (change.kind, change.shift) == ("another", (1, 0))


def test_another_side_at_its_place_is_told_as_one_difference():
    a = timeline(brow=[Interval("BrowUp", 10, 50)])
    b = timeline(brow=[Interval("BrowUp", 10, 50, "left")])
    (change,) = diff(a, b).changes
    assert change.kind == "another"


def test_actions_that_lie_apart_are_only_in_one():
    a = timeline(mouth=[Interval("Smile", 10, 20)])
    b = timeline(mouth=[Interval("Smile", 20, 30), Interval("SoftSmile", 8, 11)])
    assert [c.kind for c in diff(a, b).changes] == ["only in b", "only in a", "only in b"]


def test_an_action_cut_in_two_is_moved_and_its_smaller_half_is_new():
    a = timeline(mouth=[Interval("Smile", 10, 50)])
    b = timeline(mouth=[Interval("Smile", 10, 18), Interval("Smile", 22, 50)])
    small, large = diff(a, b).changes
    assert (small.kind, small.b) == ("only in b", Interval("Smile", 10, 18))
    assert (large.kind, large.shift) == ("moved", (12, 0))


def test_who_found_an_action_is_no_difference():
    a = timeline(mouth=[Interval("Smile", 10, 50, None, "ticc", 3, 0.9)])
    assert not diff(a, timeline(mouth=[Interval("Smile", 10, 50)]))


def test_a_track_that_one_does_not_measure_is_not_compared_but_told():
    found = diff(timeline(brow=[Interval("BrowUp", 0, 9)]), timeline(lid=[]))
    assert found and not found.changes
    assert (found.only_a, found.only_b, found.agreement) == (("brow",), ("lid",), {})


@given(timelines(), timelines())
def test_agreement_is_the_share_of_frames_and_cohen_s_kappa(a, b):
    for track, agreement in diff(a, b).agreement.items():
        one, other = classes(a, track), classes(b, track)
        assert agreement.share == pytest.approx(np.mean(one == other))
        if agreement.kappa is None:
            assert len({*one, *other}) == 1
        else:
            assert agreement.kappa == pytest.approx(cohen_kappa_score(one, other))


@pytest.mark.parametrize("other", [timeline(fps=25), timeline(n_frames=99)])
def test_other_frames_cannot_be_compared(other):
    with pytest.raises(BadFile, match="in the first timeline and"):
        diff(timeline(), other)
