from fractions import Fraction

import pytest

from mimeline.timeline.checks import judge
from mimeline.timeline.draft import Draft, DraftInterval, Problem, is_foreign, split_tier
from mimeline.timeline.timeline import Interval, Timeline
from mimeline.vocabulary import TRACKS

FPS = Fraction(25)


def draft(*intervals, **facts):
    """A draft in frames; intervals: (track, action, start, end, side)."""
    entries = tuple(
        DraftInterval(f"row {n}", track, action, Fraction(start), Fraction(end), side=side)
        for n, (track, action, start, end, side) in enumerate(intervals, start=1)
    )
    return Draft(facts.pop("clip_id", "a"), entries, facts.pop("in_seconds", False), **facts)


def problems(*intervals, **facts) -> list[tuple[str, str]]:
    """Severity and place of what is wrong in a clip of 100 frames, or looks like a slip."""
    judged = judge(draft(*intervals, **facts), "name", FPS, 100, shortest=2)
    return [(problem.severity, problem.place) for problem in judged.problems]


def test_a_good_draft_is_a_timeline():
    good = draft(("mouth", "Smile", 3, 9, None), ("brow", "BrowUp", 0, 5, "left"), tracks=("lid",))
    judged = judge(good, "name", FPS, 100, shortest=2)
    assert judged.problems == ()
    assert judged.timeline == Timeline(
        "a",
        FPS,
        100,
        {
            "brow": [Interval("BrowUp", 0, 5, "left")],
            "lid": [],
            "mouth": [Interval("Smile", 3, 9)],
        },
    )


def test_a_clip_that_its_file_does_not_name_is_called_as_the_reader_says():
    assert judge(draft(clip_id=None), "name", FPS, 100).timeline.clip_id == "name"


@pytest.mark.parametrize(
    ("intervals", "wrong"),
    [
        ([("brow", "BrowUp", 0, 5, None), ("brow", "BrowDown", 5, 9, None)], []),
        ([("brow", "BrowUp", 0, 6, None), ("brow", "BrowDown", 5, 9, None)], ["row 2"]),
        ([("brow", "BrowUp", 0, 6, "left"), ("brow", "BrowDown", 5, 9, "right")], []),
        ([("brow", "BrowUp", 0, 6, "left"), ("brow", "BrowDown", 5, 9, None)], ["row 2"]),
        ([("brow", "BrowUp", 0, 6, "left"), ("brow", "BrowDown", 5, 9, "left")], ["row 2"]),
        ([("brow", "BrowUp", 0, 6, None), ("mouth", "Smile", 5, 9, None)], []),
        (
            [
                ("brow", "BrowUp", 0, 50, None),
                ("brow", "BrowUp", 9, 12, None),
                ("brow", "BrowUp", 20, 30, None),
            ],
            ["row 2", "row 3"],
        ),
    ],
)
def test_overlap_is_an_error_only_on_one_side_of_one_track(intervals, wrong):
    assert problems(*intervals) == [("error", place) for place in wrong]


@pytest.mark.parametrize(("start", "end"), [(5, 5), (9, 5), (-1, 5), (95, 101), (200, 300)])
def test_intervals_that_are_empty_reversed_or_outside_are_errors(start, end):
    assert problems(("brow", "BrowUp", start, end, None)) == [("error", "row 1")]


def test_an_interval_may_fill_the_clip():
    assert problems(("brow", "BrowUp", 0, 100, None)) == []


def test_neutral_may_be_said_of_a_track_but_not_where_it_shows_an_action():
    neutral = ("brow", "Neutral", 0, 100, None)
    judged = judge(draft(neutral), "name", FPS, 100, shortest=2)
    assert judged.problems == () and judged.timeline.tracks == {"brow": ()}
    assert problems(neutral, ("brow", "BrowUp", 5, 9, "left")) == [("error", "row 2")]


@pytest.mark.parametrize("n_frames", [-1, 10**13])
def test_a_length_that_no_clip_has_is_an_error(n_frames):
    (problem,) = judge(draft(tracks=("brow",)), "name", FPS, n_frames).problems
    assert problem.severity == "error" and "--frames N" in problem.remedy


def test_likely_slips_are_warned_of_and_no_hindrance():
    slips = draft(
        ("brow", "BrowUp", 0, 5, None),
        ("brow", "BrowDown", 6, 9, None),  # a gap of one frame
        ("brow", "BrowDown", 9, 12, None),  # touches its like
        ("brow", "BrowUp", 12, 20, "left"),
        ("brow", "BrowUp", 20, 30, "right"),  # its like on the other side
        ("lid", "EyeSquint", 50, 51, None),  # one frame
    )
    judged = judge(slips, "name", FPS, 100, shortest=2)
    assert [(p.severity, p.place) for p in judged.problems] == [
        ("warning", "row 2"),
        ("warning", "row 3"),
        ("warning", "row 6"),
    ]
    assert judged.timeline is not None
    assert judge(slips, "name", FPS, 100).problems == ()  # unless one looks for them


def test_the_shortest_interval_is_for_the_user_to_say():
    short = draft(("brow", "BrowUp", 0, 4, None))
    assert len(judge(short, "name", FPS, 100, shortest=5).problems) == 1
    assert judge(short, "name", FPS, 100, shortest=4).problems == ()


def test_errors_come_before_warnings_each_in_the_order_of_the_file():
    found = problems(
        ("brow", "BrowUp", 0, 1, None),
        ("lid", "EyeSqint", 5, 9, None),
        ("mouth", "Smile", 9, 4, None),
    )
    assert found == [("error", "row 2"), ("error", "row 3"), ("warning", "row 1")]


def test_a_track_that_is_not_known_is_told_once_with_its_first_place():
    wrong = [("eyebrow", "BrowUp", n, n + 5, None) for n in (0, 9, 20)]
    judged = judge(draft(*wrong), "name", FPS, 100)
    (problem,) = judged.problems
    assert problem.place == "row 1" and problem.remedy == "Did you mean brow?"


def test_a_word_that_is_near_nothing_gets_no_suggestion():
    (problem,) = judge(draft(("brow", "zzz", 0, 9, None)), "name", FPS, 100).problems
    assert problem.remedy == "Name one of these actions."


@pytest.mark.parametrize("factor", [Fraction(1, 2) - Fraction(1, 100), Fraction(-1, 2)])
def test_an_edge_is_taken_for_the_nearest_frame(factor):
    edges = [Fraction(frame) + factor for frame in (10, 40)]
    seconds = draft(("brow", "BrowUp", *(edge / FPS for edge in edges), None), in_seconds=True)
    judged = judge(seconds, "name", FPS, 100)
    assert judged.timeline.tracks["brow"] == (Interval("BrowUp", 10, 40),)
    assert [p.severity for p in judged.problems] == ["warning"]


def test_edges_off_the_frames_are_one_warning_that_names_the_farthest():
    intervals = [("brow", "BrowUp", n + Fraction(n, 100), n + 5, None) for n in (0, 10, 20, 30)]
    (problem,) = judge(draft(*intervals, in_seconds=True), "name", Fraction(1), 100).problems
    assert problem.place == "row 4"
    assert (
        problem.found
        == "an edge 300.0 ms from a frame's start, and 2 more intervals off the frames"
    )


@pytest.mark.parametrize(("shift", "doubted"), [(Fraction(1, 3), True), (0, False)])
def test_where_most_edges_are_off_the_frames_the_rate_is_doubted(shift, doubted):
    ends = [(10 + shift, 15 + shift), (20 + shift, 25), (30, 35 + Fraction(1, 3))]
    intervals = [("brow", "BrowUp", *edges, None) for edges in ends]
    (problem,) = judge(draft(*intervals, in_seconds=True), "name", Fraction(1), 100).problems
    assert ("probably has another rate" in problem.remedy) is doubted


def test_names_are_checked_even_where_the_rate_is_not_told():
    judged = judge(draft(("brow", "BrwUp", 0, 1, None), in_seconds=True), "name")
    assert [p.found for p in judged.problems] == ["no frame rate", "no length", 'action "BrwUp"']


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("brow", ("brow", None)),
        ("Brow Left", ("brow", "left")),
        (" gaze_h  right ", ("gaze_h", "right")),
        ("HEAD_V", ("head_v", None)),
        ("mouth_left", ("mouth", "left")),
        ("mouth-right", ("mouth", "right")),
        ("left brow", ("left brow", None)),
        ("", ("", None)),
    ],
)
def test_tiers_are_named_by_track_and_side(name, meant):
    assert split_tier(name) == meant


@pytest.mark.parametrize(
    ("tier", "values", "foreign"),
    [
        ("speech", ("hello",), True),
        ("speech", (), True),
        ("speech", ("hello", "Smile"), False),
        ("speech", ("Neutral",), False),
        ("moth", (), False),
        *((track, ("hello",), False) for track in TRACKS),
    ],
)
def test_a_tier_is_foreign_only_if_neither_name_nor_values_are_ours(tier, values, foreign):
    assert is_foreign(tier, values) is foreign


def test_a_problem_is_one_line_that_steers_no_terminal():
    text = str(Problem("tier \x1b[31m", "a\nb", "c", "d"))
    assert "\n" not in text and "\x1b" not in text
