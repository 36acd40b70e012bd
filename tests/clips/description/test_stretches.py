import random

from hypothesis import given
from hypothesis import strategies as st

from mimeline.clips.description.stretches import Run, Stretch, runs, without_flicker
from mimeline.clips.description.telling import told

MIN_S = 1.0
TENTHS = st.integers(0, 120).map(lambda tenths: tenths / 10)


def interval(name, start_s, end_s, uncertainty_s=0.0):
    return {"name": name, "start_s": start_s, "end_s": end_s, "uncertainty_s": uncertainty_s}


def sets(parts):
    return [(part.start_s, part.end_s, set(part.throughout)) for part in parts]


def split(all_runs, duration_s):
    return told(all_runs, duration_s, MIN_S, 99, 10_000, {}, lambda name: 1)


@st.composite
def clips(draw):
    """Intervals of up to five actions, some beyond the clip, and the clip's seconds."""
    edges = st.tuples(st.sampled_from("abcde"), TENTHS, TENTHS)
    told_s = draw(st.sampled_from([0.0, 0.5, 1.0]))
    drawn = draw(st.lists(edges, max_size=10))
    intervals = [interval(name, min(x, y), max(x, y), told_s) for name, x, y in drawn]
    return intervals, draw(st.integers(40, 110)) / 10


@given(clips())
def test_away_from_changes_a_stretch_has_exactly_what_lasts_then(clip):
    intervals, duration_s = clip
    all_runs = without_flicker(runs(intervals, duration_s))
    lasting = [run for run in all_runs if run.seconds >= MIN_S - 1e-6]
    parts = split(all_runs, duration_s)
    changes = [edge for run in lasting for edge in (run.start_s, run.end_s)]
    for tenth in range(int(duration_s * 10)):
        time = tenth / 10 + 0.05
        unsure = max([MIN_S, *(run.uncertainty_s for run in lasting)])
        if any(abs(time - change) <= unsure for change in changes):
            continue
        active = {run.name for run in lasting if run.start_s <= time < run.end_s}
        here = [set(p.throughout) for p in parts if p.start_s <= time < p.end_s]
        assert (here or [set()]) == [active]


@given(clips())
def test_no_action_is_lost_whatever_is_joined(clip):
    intervals, duration_s = clip
    all_runs = without_flicker(runs(intervals, duration_s))
    parts = split(all_runs, duration_s)
    said = {name for part in parts for name in part.throughout}
    said |= {run.name for part in parts for run in part.passing}
    assert said == {run.name for run in all_runs}


@given(clips())
def test_what_lasts_has_a_stretch_and_what_passes_is_in_the_one_around_its_middle(clip):
    intervals, duration_s = clip
    for run in (all_runs := without_flicker(runs(intervals, duration_s))):
        middle = (run.start_s + run.end_s) / 2
        parts = split(all_runs, duration_s)
        if run.seconds >= MIN_S - 1e-6:
            assert any(run.name in part.throughout for part in parts)
        else:
            (around,) = [p for p in parts if p.start_s <= middle < p.end_s]
            assert run.name in around.throughout or run in around.passing


@given(clips(), st.integers())
def test_the_order_of_the_intervals_does_not_matter(clip, seed):
    intervals, duration_s = clip
    shuffled = random.Random(seed).sample(intervals, len(intervals))
    assert split(runs(shuffled, duration_s), duration_s) == split(
        runs(intervals, duration_s), duration_s
    )


@given(clips())
def test_stretches_follow_each_other_inside_the_clip(clip):
    intervals, duration_s = clip
    parts = split(runs(intervals, duration_s), duration_s)
    edges = [edge for part in parts for edge in (part.start_s, part.end_s)]
    assert edges == sorted(edges)
    assert all(0 <= edge <= duration_s for edge in edges)
    assert all(part.end_s > part.start_s for part in parts)


@given(clips(), st.integers(1, 4), st.integers(10, 60))
def test_a_busy_clip_is_told_in_few_stretches_and_what_they_say_is_seen(clip, most, words):
    intervals, duration_s = clip
    all_runs = without_flicker(runs(intervals, duration_s))
    parts = told(all_runs, duration_s, MIN_S, most, words, {}, lambda name: 2)
    assert len(parts) <= most
    for part in parts:
        for name in part.throughout:
            same = [run for run in all_runs if run.name == name]
            for time in (part.start_s, (part.start_s + part.end_s) / 2, part.end_s):
                away = min(max(run.start_s - time, time - run.end_s) for run in same)
                assert away <= MIN_S  # the longest uncertainty is no longer
        for run in part.passing:
            assert min(run.end_s, part.end_s) > max(run.start_s, part.start_s)


def test_figure_5_5_has_three_stretches():
    told_there = [("talk", 0, 11), ("gaze", 0, 11), ("frown", 2, 3), ("blink", 4, 11)]
    all_runs = runs([interval(*told, 1.0) for told in told_there], 11.0)
    assert sets(split(all_runs, 11.0)) == [
        (0.0, 2.0, {"talk", "gaze"}),
        (2.0, 3.5, {"talk", "gaze", "frown"}),
        (3.5, 11.0, {"talk", "gaze", "blink"}),
    ]


def test_an_exact_pause_is_one_and_an_overlap_of_a_second_is_told():
    pause = runs([interval("smile", 0, 3), interval("frown", 4, 8)], 8.0)
    assert sets(split(pause, 8.0)) == [(0, 3, {"smile"}), (4, 8, {"frown"})]
    overlap = runs([interval("smile", 0, 4, 1.0), interval("frown", 3, 8, 1.0)], 8.0)
    assert [actions for *_, actions in sets(split(overlap, 8.0))] == [
        {"smile"},
        {"smile", "frown"},
        {"frown"},
    ]


def test_changes_within_their_uncertainty_of_the_clips_edges_are_the_edges():
    all_runs = runs([interval("smile", 0.9, 7.2, 1.0)], 8.0)
    assert sets(split(all_runs, 8.0)) == [(0.0, 8.0, {"smile"})]
    exact = runs([interval("smile", 1.9, 6.1, 0.0)], 8.0)
    assert sets(split(exact, 8.0)) == [(1.9, 6.1, {"smile"})]


def test_a_blink_splits_no_time():
    all_runs = runs([interval("smile", 0, 8), interval("EyeClose", 4, 4.2)], 8.0)
    (part,) = split(all_runs, 8.0)
    assert part.throughout == ("smile",)
    assert part.passing == (Run(4, 4.2, "EyeClose", 0.0),)


def test_intervals_of_one_action_that_touch_are_one():
    all_runs = runs([interval("nod", 3, 5), interval("nod", 1, 3), interval("nod", 2, 4)], 9.0)
    assert [(run.start_s, run.end_s) for run in all_runs] == [(1, 5)]


def test_a_pause_that_nobody_sees_is_none_in_a_text():
    flickering = runs([interval("GazeUp", 2.33, 2.73), interval("GazeUp", 2.77, 3.4)], 9.0)
    assert len(flickering) == 2
    (part,) = told(flickering, 9.0, MIN_S, 5, 50, {}, lambda name: 2)
    assert part == Stretch(2.33, 3.4, ("GazeUp",))


def test_an_action_that_starts_and_ends_in_one_second_lasts_for_it():
    assert runs([interval("nod", 3, 3, 1.0)], 9.0) == [Run(3, 4, "nod", 1.0)]
    assert runs([interval("nod", 9, 9, 1.0)], 9.0) == [Run(8, 9, "nod", 1.0)]
    assert runs([interval("nod", 3, 3, 0.0)], 9.0) == []


def test_what_lies_outside_the_clip_is_cut_off():
    assert runs([interval("nod", -4, 20, 1.0), interval("cry", 9, 12, 0.0)], 9.0) == [
        Run(0.0, 9.0, "nod", 1.0)
    ]


def test_where_too_much_is_seen_the_shortest_pass_without_splitting():
    intervals = [interval(name, n, n + 1.5 + n / 10) for n, name in enumerate("abcdefg")]
    all_runs = runs(intervals, 9.0)
    assert len(split(all_runs, 9.0)) > 3
    parts = told(all_runs, 9.0, MIN_S, 3, 100, {}, lambda name: 1)
    passing = {run.name for part in parts for run in part.passing}
    lasting = {name for part in parts for name in part.throughout}
    assert len(parts) <= 3
    assert passing | lasting == set("abcdefg")
    assert max(passing) < min(lasting)  # the later letters last longer


def test_what_is_too_long_to_tell_is_left_out_the_told_and_the_short_first():
    intervals = [interval("smile", 0, 4), interval("frown", 4, 8)]
    intervals += [interval("nod", 1, 1.4), interval("nod", 5, 5.9), interval("wink", 2, 2.1)]
    all_runs = runs(intervals, 8.0)
    parts = told(all_runs, 8.0, MIN_S, 5, 2 * 7 + 4 * 2, {}, lambda name: 1)
    assert [[run.name for run in part.passing] for part in parts] == [["wink"], ["nod"]]


def test_something_is_told_of_every_stretch_before_more_of_one():
    intervals = [interval("squint", 0, 1.7), interval("frown", 2.2, 6), interval("smile", 2.2, 9)]
    intervals += [interval("nod", n, n + 0.5) for n in (2.5, 4, 5)]
    parts = told(runs(intervals, 9.0), 9.0, MIN_S, 5, 3 * 7 + 3 * 2, {}, lambda name: 1)
    assert [(part.throughout, {run.name for run in part.passing}) for part in parts] == [
        ((), {"squint"}),
        (("smile",), {"frown", "nod"}),
    ]


def test_what_is_seen_where_nothing_lasts_is_told_there_though_its_middle_lies_elsewhere():
    intervals = [interval("smile", 0.3, 4.3), interval("widen", 1.4, 5.5), interval("nod", 1, 1.3)]
    parts = told(runs(intervals, 9.0), 9.0, MIN_S, 2, 2 * 7 + 2 * 2, {}, lambda name: 1)
    assert [(part.throughout, {run.name for run in part.passing}) for part in parts] == [
        ((), {"smile"}),
        (("widen",), set()),
    ]


def test_something_is_told_however_few_words_are_allowed():
    all_runs = runs([interval("smile", 0, 4), interval("frown", 4, 8.5)], 8.5)
    (part,) = told(all_runs, 8.5, MIN_S, 5, 1, {}, lambda name: 3)
    assert [run.name for run in part.passing] == ["frown"]
