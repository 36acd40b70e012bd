"""Timelines of a run's tables, and the truth that a person makes of them."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.annotation.annotate import intervals_of
from mimeline.annotation.timelines import frames_of, read_truth, timelines_of
from mimeline.errors import BadFile, NoSuchFile
from mimeline.timeline import files
from mimeline.timeline.timeline import Interval, Timeline
from mimeline.vocabulary import ACTIONS, TRACKS, track_actions

LENGTHS = {"a": 60, "b-1": 45, "c": 30}
FPS = Fraction(30000, 1001)
DROPPED = {"turned": ("dropped", "pose", "turned"), "torn": ("failed", "fetch", "unreadable")}
LEDGER = pd.DataFrame(
    [("a", "kept", "pose", None), *((clip, *why) for clip, why in DROPPED.items())],
    columns=["clip_id", "status", "stage", "rule"],
)


@pytest.fixture
def clips() -> pd.DataFrame:
    return pd.DataFrame(
        {
            "clip_id": list(LENGTHS),
            "fps_num": FPS.numerator,
            "fps_den": FPS.denominator,
            "n_frames": pd.array(list(LENGTHS.values()), dtype="Int64"),
        }
    )


@pytest.fixture
def frames() -> pd.DataFrame:
    """Every track shows its actions and none by turns; the gaze of clip c is not measured."""
    parts = []
    for clip_id, n in LENGTHS.items():
        part = pd.DataFrame({"clip_id": clip_id, "frame": np.arange(n)})
        for offset, track in enumerate(TRACKS):
            state = (np.arange(n) + offset) // 7 % (len(track_actions(track)) + 1)
            for number, action in enumerate(track_actions(track), start=1):
                part[action] = pd.array(state == number, dtype="boolean")
        parts.append(part)
    frames = pd.concat(parts, ignore_index=True)
    gaze = [*track_actions("gaze_h"), *track_actions("gaze_v")]
    frames.loc[frames["clip_id"] == "c", gaze] = pd.NA
    return frames[tables.FRAMES.schema.names]


@pytest.fixture
def timelines(frames, clips) -> dict[str, Timeline]:
    return timelines_of(intervals_of(frames, {}), frames, clips)


def test_a_timeline_has_the_intervals_the_clock_and_the_measured_tracks(timelines, frames):
    a = timelines["a"]
    assert (a.clip_id, a.fps, a.n_frames) == ("a", FPS, 60)
    assert list(a.tracks) == list(TRACKS)
    assert list(timelines["c"].tracks) == [t for t in TRACKS if not t.startswith("gaze")]
    (first, *_) = a.tracks["brow"]
    assert (first.action, first.start, first.end, first.source) == ("BrowUp", 7, 14, "ticc")


def test_timelines_lead_back_to_their_frames(timelines, frames):
    pd.testing.assert_frame_equal(frames_of(timelines), frames)


def test_a_track_of_which_some_frames_are_known_is_measured(frames, clips):
    frames.loc[3:9, list(ACTIONS)] = pd.NA
    found = timelines_of(intervals_of(frames, {}), frames, clips)
    assert list(found["a"].tracks) == list(TRACKS)
    back = frames_of(found).set_index(["clip_id", "frame"])
    known = frames.set_index(["clip_id", "frame"])
    assert ((back == known) | known.isna()).all(axis=None)


def test_frames_whose_sides_show_different_actions_have_no_class():
    brow = [Interval("BrowUp", 0, 6, "left"), Interval("BrowDown", 4, 9, "right")]
    rows = frames_of({"a": Timeline("a", FPS, 10, {"brow": brow})})
    assert rows["BrowUp"].tolist() == [True] * 4 + [pd.NA] * 2 + [False] * 4
    assert rows["BrowDown"].isna().tolist() == [False] * 4 + [True] * 2 + [False] * 4
    assert rows["Smile"].isna().all()


@pytest.mark.parametrize("ending", files.SUFFIXES)
def test_exported_timelines_are_read_as_the_frames_that_they_come_from(
    tmp_path, timelines, frames, clips, ending
):
    for clip_id, timeline in timelines.items():
        files.write(timeline, tmp_path / f"{clip_id}{ending}")
    (tmp_path / "notes.pdf").write_bytes(b"")
    truth = read_truth(tmp_path, clips, LEDGER)
    pd.testing.assert_frame_equal(truth, frames)
    tables.write(tables.FRAMES, truth, tmp_path / "kept.parquet")


def test_one_file_of_several_clips_is_a_truth(tmp_path, timelines, frames, clips):
    for name in ("all.csv", "all.json"):
        files.write_all(timelines.values(), tmp_path / name)
        pd.testing.assert_frame_equal(read_truth(tmp_path / name, clips, LEDGER), frames)


def test_a_planted_truth_goes_before_files(tmp_path, timelines, frames, clips):
    tables.write(tables.FRAMES, frames.head(5), tmp_path / "frames.parquet")
    files.write(timelines["c"], tmp_path / "c.eaf")
    assert len(read_truth(tmp_path, clips, LEDGER)) == 5


def test_a_planted_truth_that_outlasts_a_clip_is_warned_of(tmp_path, frames, clips, caplog):
    tables.write(tables.FRAMES, frames, tmp_path / "frames.parquet")
    read_truth(tmp_path, clips, LEDGER)
    assert caplog.records == []
    read_truth(tmp_path, clips.replace({"n_frames": {45: 22}}), LEDGER)
    assert "beyond the end of clip b-1 (22 frames, not 45); with another" in caplog.text


def test_clips_without_a_file_and_tracks_without_a_tier_are_not_judged(
    tmp_path, timelines, clips, caplog
):
    files.write(replace(timelines["a"], tracks={"brow": []}), tmp_path / "a.TextGrid")
    with caplog.at_level("INFO"):
        truth = read_truth(tmp_path, clips, LEDGER)
    assert set(truth["clip_id"]) == {"a"}
    assert not truth[["BrowUp", "BrowDown"]].any(axis=None)
    assert truth[[a for a in ACTIONS if not a.startswith("Brow")]].isna().all(axis=None)
    assert "timelines of 1 of 3 clips" in caplog.text


def test_clips_that_the_run_did_not_keep_are_warned_of_and_the_others_scored(
    tmp_path, timelines, clips, frames, caplog
):
    lost = {"fps": Fraction(25), "n_frames": 999}
    files.write(timelines["a"], tmp_path / "a.eaf")
    files.write(replace(timelines["a"], clip_id="turned", **lost), tmp_path / "turned.eaf")
    several = [timelines["b-1"], replace(timelines["b-1"], clip_id="torn", **lost)]
    files.write_all(several, tmp_path / "rest.csv")
    truth = read_truth(tmp_path, clips, LEDGER)
    expected = frames[frames["clip_id"] != "c"].reset_index(drop=True)
    pd.testing.assert_frame_equal(truth, expected)
    (warning,) = [r.getMessage() for r in caplog.records if r.levelname == "WARNING"]
    assert "torn (failed at fetch: unreadable), turned (dropped at pose: turned)" in warning
    assert "not scored" in warning and "mimeline why" in warning


def test_where_none_of_the_clips_was_kept_nothing_is_judged(tmp_path, timelines, clips):
    files.write(replace(timelines["a"], clip_id="turned"), tmp_path / "turned.eaf")
    assert read_truth(tmp_path, clips, LEDGER).empty


def test_unnamed_clips_of_one_file_are_asked_for_by_their_own_names(tmp_path, timelines, clips):
    files.write_all([timelines["a"], timelines["a"]], tmp_path / "a.txt")
    with pytest.raises(BadFile, match="clip a_1: found no clip of that name"):
        read_truth(tmp_path, clips, LEDGER)


@pytest.mark.parametrize(
    ("changed", "name", "told"),
    [
        ({"clip_id": "b-11"}, "b-1.eaf", ["clip b-11", "no clip of that name", "Near it: b-1."]),
        ({"clip_id": "turnd"}, "turnd.eaf", ["no clip of that name", "Near it: turned."]),
        ({}, "unheard.TextGrid", ["clip unheard", "no clip of that name", "one of the 3"]),
        ({"fps": Fraction(30)}, "b-1.json", ["30 frames per second", "30000/1001", "export"]),
        ({"n_frames": 46}, "b-1.vtt", ["46 frames", "45, as the run has them", "export"]),
    ],
)
def test_a_file_of_another_clip_rate_or_length_is_refused(
    tmp_path, timelines, clips, changed, name, told
):
    files.write(replace(timelines["b-1"], **changed), tmp_path / name)
    with pytest.raises(BadFile) as error:
        read_truth(tmp_path, clips, LEDGER)
    assert str(error.value).startswith(str(tmp_path / name))
    assert all(text in str(error.value) for text in told)


def test_two_files_of_one_clip_are_refused(tmp_path, timelines, clips):
    files.write(timelines["a"], tmp_path / "a.eaf")
    files.write(timelines["a"], tmp_path / "a.TextGrid")
    with pytest.raises(BadFile, match="a.eaf: clip a|the clip that .* is of"):
        read_truth(tmp_path, clips, LEDGER)


def test_where_no_timeline_is_the_error_says_how_to_make_them(tmp_path, clips):
    for truth in (tmp_path, tmp_path / "missing"):
        with pytest.raises(NoSuchFile, match="mimeline timeline export"):
            read_truth(truth, clips, LEDGER)
