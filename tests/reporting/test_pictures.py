import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.reporting import words
from mimeline.reporting.channels import channels
from mimeline.reporting.confusion import matrices
from mimeline.reporting.dots import dot_chart
from mimeline.reporting.drawing import Scale, curve, second_ticks, ticks
from mimeline.reporting.filmstrip import places
from mimeline.reporting.gauge import WIDTH, gauge
from mimeline.reporting.interval_scores import Value, lines
from mimeline.reporting.scores import scores
from mimeline.reporting.timelines import choose, stretches
from mimeline.reporting.training import loss_curve
from mimeline.vocabulary import ACTIONS


def test_a_gap_in_the_data_is_a_gap_in_the_curve():
    x, y = Scale(0, 3, 0, 30), Scale(0, 1, 10, 0)
    assert curve([0, 1, 2, 3], [0, np.nan, 1, 1], x, y) == "M0 10M20 0L30 0"


@pytest.mark.parametrize(("low", "high"), [(0, 1), (0.8, 1), (0, 1500), (-30, 30), (2, 2)])
def test_ticks_are_round_few_and_within_the_range(low, high):
    marks = ticks(low, high)
    assert 1 <= len(marks) <= 11
    assert all(low - 1e-9 <= mark <= high + 1e-9 for mark in marks)


def test_seconds_of_a_long_span_are_thinned():
    assert second_ticks(0, 5) == [0, 1, 2, 3, 4, 5]
    assert len(second_ticks(0, 3600)) <= 13


def test_clips_that_show_new_actions_are_chosen_first():
    intervals = pd.DataFrame(
        [("a", "BrowUp"), ("a", "BrowDown"), ("b", "BrowUp"), ("b", "BrowDown"), ("c", "Smile")],
        columns=["clip_id", "action"],
    )
    assert choose(intervals, ["a", "b", "c", "d"], 2) == ["a", "c"]
    assert choose(intervals, ["d", "c", "b", "a"], 4) == ["a", "c", "b", "d"]
    assert choose(intervals, ["a", "b", "c", "d"], 3, filmed={"b", "d"}) == ["b", "d", "c"]


def test_stretches_end_where_the_action_changes_or_frames_are_missing():
    frames = pd.DataFrame({"clip_id": "a", "frame": [0, 1, 2, 5, 6]})
    marks = pd.DataFrame(False, index=range(5), columns=list(ACTIONS)).astype("boolean")
    marks["BrowUp"] = [True, True, False, False, True]
    marks["BrowDown"] = [False, False, True, True, False]
    frames = pd.concat([frames, marks.astype("boolean")], axis=1)
    assert stretches(frames, "brow") == [
        ("BrowUp", 0, 2),
        ("BrowDown", 2, 3),
        ("BrowDown", 5, 6),
        ("BrowUp", 6, 7),
    ]
    frames["BrowUp"] = pd.array([pd.NA, pd.NA, False, False, True], dtype="boolean")
    assert [run[1:] for run in stretches(frames, "brow", gaps=True)] == [(0, 2)]


def test_an_action_that_is_unmeasured_throughout_leaves_no_gap_where_the_others_are_known():
    marks = pd.DataFrame(False, index=range(5), columns=list(ACTIONS)).astype("boolean")
    marks["Smile"] = pd.array([False, True, True, False, pd.NA], dtype="boolean")
    marks["MouthFrown"] = pd.array([pd.NA] * 5, dtype="boolean")
    frames = pd.concat([pd.DataFrame({"clip_id": "a", "frame": range(5)}), marks], axis=1)
    assert stretches(frames, "mouth") == [("Smile", 1, 3)]
    gaps = [stretches(frames, "mouth", absent, gaps=True) for absent in ([], ["MouthFrown"])]
    assert [[run[1:] for run in runs] for runs in gaps] == [[(0, 1), (3, 5)], [(4, 5)]]


def test_losses_over_a_wide_range_are_drawn_on_a_logarithmic_axis():
    losses = pd.DataFrame({"step": [1, 2, 3], "val_loss": np.nan, "learning_rate": 0.1})
    assert loss_curve(losses.assign(loss=[9.0, 1.0, 0.5])).logarithmic
    plot = loss_curve(losses.assign(loss=[0.9, 0.8, 0.7]))
    assert not plot.logarithmic
    assert [line.name for line in plot.lines] == ["training"]


def test_the_scale_of_a_dot_chart_reaches_below_every_whisker():
    rows = [("f1_brow", "named", 0.9, 0.55, 0.95), ("f1_brow", "gmm", np.nan, np.nan, np.nan)]
    table = pd.DataFrame(rows, columns=["metric", "variant", "value", "low", "high"])
    chart = dot_chart(table, "f1_", {"brow": "brow", "eye": "eye"}, ["named", "gmm"])
    assert chart.variants == ["named"]
    assert [group.name for group in chart.groups] == ["brow"]
    assert chart.left <= chart.groups[0].dots[0].low < chart.groups[0].dots[0].x
    assert dot_chart(table[:0], "f1_", {"brow": "brow"}, ["named"]) is None


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (0.243, "share of frames", "24 % of frames"),
        (12.7, "s", "12.7 s"),
        (4.43333, "s", "4.43 s"),
        (300, "px", "300 px"),
        (35.0, "deg", "35°"),
        (2.5, None, "2.5"),
        (None, "s", ""),
    ],
)
def test_a_measure_is_told_in_its_unit(value, unit, text):
    assert words.measure(value, unit) == text


@pytest.mark.parametrize(
    ("share", "text"),
    [
        (0, "0 %"),
        (0.0001, "< 0.1 %"),
        (0.034, "3.4 %"),
        (0.5, "50 %"),
        (0.999, "> 99 %"),
        (1, "100 %"),
    ],
)
def test_a_share_is_not_rounded_to_none_or_all(share, text):
    assert words.percent(share) == text


def test_actions_are_named_in_words():
    assert [words.short(a) for a in ("BrowUp", "SoftSmile", "MouthFrown", "EyeClose")] == [
        "up",
        "soft smile",
        "frown",
        "close",
    ]


def test_a_channel_is_measured_flat_or_absent(run):
    found = channels(run()["statistics"], [])
    assert (found.measured, found.absent, found.dead) == (56, ["browDownLeft"], ["browDownRight"])
    left, right = found.regions["brow"][0].bars
    assert (left.side, left.state, right.state) == ("Left", "absent", "dead")
    assert [cell.name for cell in found.regions["jaw"]][1] == "jawLeft"


def test_a_channel_tells_why_it_is_absent_or_what_a_face_model_kept_of_it(run):
    given = run()
    found = channels(given["statistics"], given["origins"])
    assert found.why_absent == {"the tracker has no brows": ["browDownLeft"]}
    assert [(m.name, m.quality) for m in found.mapped] == [("browInnerUp", pytest.approx(0.62))]


def test_a_confusion_matrix_tells_shares_of_the_true_frames_and_their_intervals(run, empty_run):
    brow = matrices(run()["confusion"])
    assert [matrix.track for matrix in brow] == ["brow"]
    assert brow[0].names == ["Neutral", "BrowUp", "BrowDown"]
    assert [(row.action, row.frames) for row in brow[0].rows] == [("Neutral", 30), ("BrowUp", 30)]
    missed, met, never = brow[0].rows[1].cells
    assert (missed.text, missed.spread, missed.right) == ("10 %", "5.0–15", False)
    assert (met.share, met.text, met.right) == (0.9, "90 %", True)
    assert (never.share, never.text, never.spread) == (0, "", "")
    title = "brow up, taken for neutral: 10 % of 30 frames, 95 % interval 5.0 to 15.0 %"
    assert missed.title == title
    assert matrices(empty_run["confusion"]) == []


def test_a_confusion_of_one_clip_has_no_intervals_and_none_says_all_where_it_is_not(run):
    path = run()["confusion"]
    shares = tables.read(tables.CONFUSION, path)
    tables.write(tables.CONFUSION, shares.assign(low=None, high=None), path)
    (brow,) = matrices(path)
    assert {cell.spread for row in brow.rows for cell in row.cells} == {""}
    assert not any("interval" in cell.title for row in brow.rows for cell in row.cells)
    tables.write(tables.CONFUSION, shares.assign(low=0.9961, high=0.9999), path)
    (brow,) = matrices(path)
    assert brow.rows[1].cells[1].spread == "99.6–99.9"


def test_a_line_tells_whether_the_edges_of_a_regions_intervals_are_early_or_late(run):
    (line,) = lines(
        tables.read(tables.METRICS, run()["annotation_metrics"]), {"brow": "brow"}, ["named", "gmm"]
    )
    assert (line.region, line.variant, line.found, line.true) == ("brow", "named", 16, 12)
    assert line.precision == Value("0.75", "0.65–0.85")
    assert line.start == Value("1.50", "1.40–1.60", "0.52 early")
    assert line.end.remark == "on time"
    assert line.within == Value("80 %", "70–90")


def test_an_action_has_no_share_where_its_absence_is_never_known(run):
    marks = pd.DataFrame(False, index=range(4), columns=list(ACTIONS)).astype("boolean")
    marks["MouthFrown"] = pd.array([True, pd.NA, pd.NA, pd.NA], dtype="boolean")
    marks["Smile"] = pd.array([True, False, pd.NA, pd.NA], dtype="boolean")
    frames = pd.concat([pd.DataFrame({"clip_id": "a", "frame": range(4)}), marks], axis=1)
    found = scores(run()["annotation_metrics"], frames, None)
    told = {share.action: share.text for share in found.shares["mouth"]}
    assert told == {"SoftSmile": "0 %", "Smile": "50 %", "MouthFrown": "not measured"}


def test_a_truth_of_some_clips_is_told_as_such_and_never_drawn_beside_all(run):
    keys = pd.DataFrame({"clip_id": list("aabb"), "frame": [0, 1, 0, 1]})
    marks = pd.DataFrame(False, index=range(4), columns=list(ACTIONS)).astype("boolean")
    frames = pd.concat([keys, marks], axis=1)
    metrics = run()["annotation_metrics"]
    whole, some = scores(metrics, frames, frames), scores(metrics, frames, frames[:2])
    assert (whole.against, some.against) == ("the truth", "the truth of 1 of the 2 clips")
    assert "no intervals" in some.caution
    assert all(share.truth == 0 for own in whole.shares.values() for share in own)
    assert all(share.truth is None for own in some.shares.values() for share in own)


@pytest.mark.parametrize(("value", "limit"), [(12.7, 10.0), (3.4, 5.0), (0.25, 0.1), (0, 2)])
def test_a_gauge_is_in_proportion(value, limit):
    shown = gauge(value, limit)
    assert max(shown.value, shown.limit) == WIDTH
    assert shown.value * limit == pytest.approx(shown.limit * value, abs=0.1 * max(value, limit))
    assert shown.over == (value > limit)


@pytest.mark.parametrize(
    ("value", "limit"), [(None, 3), (np.nan, 3), (2, np.nan), (-1, 3), (np.inf, 3), (0, 0)]
)
def test_without_two_numbers_there_is_no_gauge(value, limit):
    assert gauge(value, limit) is None


def test_the_pictures_of_a_strip_fill_the_axis_and_stand_at_their_times():
    x = Scale(30, 330, 112, 840)
    strip = places(30, 300, x)
    assert strip[0].x == 112
    assert strip[-1].x + strip[-1].edge == pytest.approx(x(300), abs=0.2)
    for place in strip:
        assert place.x < x(place.frame + 0.5) < place.x + place.edge
        assert abs(x(place.frame + 0.5) - place.x - place.edge / 2) < 3
    assert [place.frame for place in places(0, 1, Scale(0, 300, 0, 700))] == [0]
