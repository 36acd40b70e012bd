from fractions import Fraction
from itertools import pairwise, product

import numpy as np
import pandas as pd
import pytest
from scipy.optimize import linear_sum_assignment

from mimeline.annotation.scores import interval, judged, resampled
from mimeline.annotation.segment_scores import segment_counts, segment_draws
from mimeline.vocabulary import ACTIONS

LETTERS = {
    "brow": {"u": "BrowUp", "d": "BrowDown"},
    "mouth": {"s": "SoftSmile", "l": "Smile", "f": "MouthFrown"},
    "lid": {"q": "EyeSquint", "w": "EyeWiden"},
    "closure": {"c": "EyeClose"},
    "gaze_h": {"l": "GazeLeft", "r": "GazeRight"},
    "gaze_v": {"u": "GazeUp", "d": "GazeDown"},
}


def frames_of(**tracks) -> pd.DataFrame:
    """A `frames` table. tracks: a letter per frame, . neutral, ? unknown; one text, or several by
    clip. What is not given is not measured."""
    clips = {t: v if isinstance(v, dict) else {"a": v} for t, v in tracks.items()}
    first = next(iter(clips.values()))
    keys = [(clip, frame) for clip, text in first.items() for frame in range(len(text))]
    table = pd.DataFrame(keys, columns=["clip_id", "frame"])
    table = table.assign(**dict.fromkeys(ACTIONS, pd.NA)).astype(dict.fromkeys(ACTIONS, "boolean"))
    for track, texts in clips.items():
        letters = "".join(texts.values())
        for letter, action in LETTERS[track].items():
            marks = [pd.NA if c == "?" else c == letter for c in letters]
            table[action] = pd.array(marks, dtype="boolean")
    return table


def scores_of(true: pd.DataFrame, found: pd.DataFrame, overlap: float = 0.5) -> dict:
    """Region → score → value on all clips."""
    tracks = judged(true, found)
    clips = next(iter(tracks.values())).n_clips if tracks else 0
    draws = segment_draws(segment_counts(tracks, overlap), np.ones((1, clips)))
    return {r: {name: float(d.values[0]) for name, d in own.items()} for r, own in draws.items()}


def brow_scores(true: str, found: str, overlap: float = 0.5) -> dict:
    return scores_of(frames_of(brow=true), frames_of(brow=found), overlap)["brow"]


def counts_of(true: str, found: str, overlap: float = 0.5) -> tuple[int, int, int]:
    """Intervals in truth, found, and that meet."""
    tracks = judged(frames_of(brow=true), frames_of(brow=found))
    own = segment_counts(tracks, overlap)["brow"]
    return int(own.true.sum()), int(own.found.sum()), int(own.met.sum())


def test_the_truth_itself_scores_one_and_no_frame():
    table = frames_of(brow="..uu.dd..", mouth=".sss.lll.", gaze_h=".ll...rr.", gaze_v="..uuudd..")
    for own in scores_of(table, table).values():
        assert [own[f"segment_{k}"] for k in ("f1", "precision", "recall")] == [1, 1, 1]
        for edge in ("boundary", "start", "end"):
            assert [own[f"{edge}_{k}"] for k in ("mean", "median", "bias")] == [0, 0, 0]
            assert own[f"{edge}_within_2"] == 1


@pytest.mark.parametrize("shift", [-3, -1, 2, 3])
def test_intervals_that_lie_so_many_frames_off_have_that_error_at_both_edges(shift):
    true = ".....uuuuuuuuuu.......dddddddddd....."
    found = "".join(np.roll(list(true), shift))
    own = brow_scores(true, found)
    assert own["segment_f1"] == 1
    for edge in ("boundary", "start", "end"):
        assert own[f"{edge}_mean"] == own[f"{edge}_median"] == abs(shift)
        assert own[f"{edge}_bias"] == shift
        assert own[f"{edge}_within_2"] == (abs(shift) <= 2)


def test_start_and_end_are_told_apart():
    own = brow_scores("...uuuuuuuu...", "..uuuuuuuuuuu.")
    assert (own["start_bias"], own["end_bias"]) == (-1, 2)
    assert (own["boundary_mean"], own["boundary_median"], own["boundary_bias"]) == (1.5, 1.5, 0.5)


@pytest.mark.parametrize(
    ("true", "found", "counts"),
    [
        (".uuuu.", ".uu...", (1, 1, 1)),  # half is enough
        (".uuuu.", ".u....", (1, 1, 0)),
        (".uuuu.", ".dddd.", (1, 1, 0)),  # another action
        (".uuuu.", ".uu.u.", (1, 2, 1)),
        (".uuuu.", ".uuddu", (1, 3, 1)),
        (".uu.uu.", ".uuuuu.", (2, 1, 0)),  # two fifths of it each
        ("......", ".uu...", (0, 1, 0)),
        (".uu...", "......", (1, 0, 0)),
    ],
)
def test_an_interval_is_met_where_they_share_half_of_what_either_has(true, found, counts):
    assert counts_of(true, found) == counts


def test_an_interval_is_met_once():
    assert counts_of("uuuu", "uu.u", overlap=0.25) == (1, 2, 1)
    assert counts_of("uu.u", "uuuu", overlap=0.25) == (2, 1, 1)


def test_precision_is_of_what_is_found_and_recall_of_what_is_true():
    own = brow_scores(".uuu..ddd......", ".uuu....uu.u.u.")
    assert own["segment_precision"] == pytest.approx(1 / 4)
    assert own["segment_recall"] == pytest.approx(1 / 2)
    assert own["segment_f1"] == pytest.approx(2 / 6)


def test_where_nothing_is_found_there_is_no_precision_and_no_error():
    own = brow_scores(".uuu.", ".....")
    assert own["segment_recall"] == own["segment_f1"] == 0
    assert all(np.isnan(own[k]) for k in ("segment_precision", "boundary_mean", "end_median"))


def test_frames_that_do_not_count_neither_end_an_interval_nor_belong_to_it():
    assert counts_of("..uuuuuu..", "..uu??uu..") == (1, 1, 1)
    assert counts_of("..uuuuuu..", "..u????...", overlap=0.5) == (1, 1, 1)  # 1 of 2 that count
    assert counts_of("..uuuuuu..", "..u???....", overlap=0.5) == (1, 1, 0)  # 1 of 3


def test_an_edge_beside_a_frame_that_does_not_count_is_not_judged():
    own = brow_scores("..uuuuuu...", "..uuuu??uu.")
    assert own["start_mean"] == 0
    assert np.isnan(own["end_mean"])
    own = brow_scores("..uuuuuu...", ".?uuuuu....")
    assert np.isnan(own["start_mean"])
    assert own["end_bias"] == own["boundary_bias"] == -1


def test_an_edge_that_truth_has_where_the_clip_is_cut_is_not_judged():
    own = brow_scores("uuuuuu....", ".uuuuuu...")
    assert np.isnan(own["start_mean"])
    assert own["end_mean"] == 1
    own = brow_scores("..uuuuuu..", "uuuuuuuuu.")  # but one that is found there is
    assert (own["start_bias"], own["end_bias"]) == (-2, 1)


def test_an_error_over_frames_that_do_not_count_is_in_frames_of_the_clip():
    own = brow_scores("..uuuuuuuuu...", "..uuuuu??.....", overlap=0.3)
    assert np.isnan(own["end_mean"])  # beside them
    own = brow_scores("..uuuuuuuuuu...", "..uuuu.???.....", overlap=0.3)
    assert own["end_bias"] == -6


def test_intervals_end_with_their_clip():
    true = frames_of(brow={"a": "..uu", "b": "uu.."})
    counts = segment_counts(judged(true, true), 0.5)["brow"]
    assert counts.true.tolist() == counts.met.tolist() == [1, 1]
    assert counts.starts.clip.tolist() == [0] and counts.ends.clip.tolist() == [1]


def test_a_blink_does_not_cut_a_squint_in_two():
    true = frames_of(lid="..qqqqqq..", closure="...ccc....")
    found = frames_of(lid="..q...qq..", closure="...ccc....")
    assert scores_of(true, found)["eye"]["segment_f1"] == 1


def test_gaze_counts_the_intervals_of_its_two_tracks_together():
    true = frames_of(gaze_h=".ll.ll.ll.", gaze_v="...uuuu...")
    found = frames_of(gaze_h=".ll.ll.ll.", gaze_v="..........")
    assert scores_of(true, found)["gaze"]["segment_recall"] == pytest.approx(3 / 4)


def test_what_is_not_measured_has_no_score():
    full, part = frames_of(brow=".uu.", mouth=".ss."), frames_of(mouth=".ss.")
    assert list(scores_of(full, part)) == list(scores_of(part, full)) == ["mouth"]
    assert scores_of(part, frames_of(brow=".uu.")) == {}


def runs_of(text: str) -> list[tuple[str, int, int]]:
    """Action, start, end of the intervals."""
    cuts = [0, *(k for k in range(1, len(text)) if text[k] != text[k - 1]), len(text)]
    runs = [(text[a], a, b) for a, b in pairwise(cuts)]
    return [run for run in runs if run[0] != "."]


def most_that_meet(true: str, found: str, overlap: float) -> int:
    """The size of a largest one-to-one matching, by assignment over all pairs."""
    allowed = np.zeros((len(runs_of(true)), len(runs_of(found))))
    for (i, (a, s, e)), (j, (b, t, f)) in product(
        enumerate(runs_of(true)), enumerate(runs_of(found))
    ):
        both = max(0, min(e, f) - max(s, t))
        allowed[i, j] = a == b and Fraction(both, e - s + f - t - both) >= Fraction(str(overlap))
    return int(allowed[linear_sum_assignment(-allowed)].sum())


@pytest.mark.parametrize("overlap", [0.1, 0.25, 0.5, 0.7])
def test_no_other_pairing_meets_more_intervals(overlap):
    rng = np.random.default_rng(1)
    texts = ["".join(rng.choice(list("...uud"), 40).repeat(rng.integers(1, 4))) for _ in range(60)]
    true, found = {}, {}
    for number, (text, noise) in enumerate(pairwise(texts)):
        clip, length = f"{number:02}", min(len(text), len(noise))
        keep = rng.random(length) < 0.6
        true[clip] = text[:length]
        found[clip] = "".join(np.where(keep, list(text[:length]), list(noise[:length])))
    own = segment_counts(judged(frames_of(brow=true), frames_of(brow=found)), overlap)["brow"]
    expected = [
        (len(runs_of(t)), len(runs_of(f)), most_that_meet(t, f, overlap))
        for t, f in zip(true.values(), found.values(), strict=True)
    ]
    assert list(zip(own.true, own.found, own.met, strict=True)) == expected


def test_the_order_of_rows_makes_no_difference():
    true = frames_of(brow={"a": "..uuu.dd", "b": "uu..dd.."})
    found = frames_of(brow={"a": ".uuuu.dd", "b": "uuu..d.."})
    shuffled = [table.sample(frac=1, random_state=0) for table in (true, found)]
    assert scores_of(*shuffled) == scores_of(true, found)


def test_an_action_that_a_clip_shows_throughout_is_judged_though_frames_are_unknown():
    true, found = frames_of(gaze_h="llllll"), frames_of(gaze_h={"a": "ll??ll", "b": "..rr.."})
    assert scores_of(true, found)["gaze"]["segment_f1"] == 1


@pytest.fixture(scope="module")
def many():
    """Forty clips of one track, found with errors: tables of truth and of what was found."""
    rng = np.random.default_rng(2)
    true, found = {}, {}
    for number in range(40):
        clip = f"{number:02}"
        text = "." * 5 + "".join(rng.choice(list(".ud"), 8).repeat(rng.integers(5, 15)))
        true[clip] = text + "." * 5
        found[clip] = "".join(np.roll(list(true[clip]), rng.integers(-3, 4)))
    return frames_of(brow=true), frames_of(brow=found)


def test_an_interval_holds_its_value_and_repeats_for_a_seed(many):
    counts = segment_counts(judged(*many), 0.5)

    def scored(seed):
        draws = segment_draws(counts, resampled(40, 200, np.random.default_rng(seed)))["brow"]
        return {name: interval(own.values) for name, own in draws.items()}

    first = scored(3)
    for name, (value, low, high) in first.items():
        assert low <= value <= high, name
    assert first["boundary_mean"][1] < first["boundary_mean"][2]
    assert scored(3) == first != scored(4)


def test_a_draw_is_the_score_of_the_clips_that_it_drew(many):
    true, found = many
    weights = resampled(40, 5, np.random.default_rng(0))
    draws = segment_draws(segment_counts(judged(true, found), 0.5), weights)["brow"]
    clips = sorted(true["clip_id"].unique())
    for row in (1, 5):
        drawn = [
            (c, copy) for c, n in zip(clips, weights[row], strict=True) for copy in range(int(n))
        ]
        again = [
            pd.concat([t[t["clip_id"] == c].assign(clip_id=f"{c} {copy}") for c, copy in drawn])
            for t in (true, found)
        ]
        own = scores_of(*again)["brow"]
        for name, values in draws.items():
            assert values.values[row] == pytest.approx(own[name]), name


def test_one_clip_has_scores_and_no_intervals():
    assert resampled(1, 50, np.random.default_rng(0)).tolist() == [[1]]
    assert np.isnan(interval(np.array([0.5]))[1:]).all()
