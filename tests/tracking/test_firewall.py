from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from mimeline.errors import BadFile, MimelineError
from mimeline.tracking import detectors, firewall
from mimeline.tracking.formats import bfm, livelink, openface, pyfeat
from mimeline.tracking.take import Take, assemble
from mimeline.vocabulary import CHANNELS, EXPRESSIONS, HEAD

FRAMES = 240
LOOKS = ("InLeft", "OutLeft", "InRight", "OutRight")


@pytest.fixture
def lively() -> Take:
    """Eight seconds in which everything moves, its noise cut off at 0 as ARKit does."""
    rng = np.random.default_rng(0)
    t = np.arange(FRAMES) / 30
    motion = pd.DataFrame(rng.normal(0, 0.02, (FRAMES, len(EXPRESSIONS))), columns=EXPRESSIONS)
    motion += 0.3 * np.maximum(0, np.sin(t[:, None] + np.arange(len(EXPRESSIONS))))
    look = 0.5 * np.sin(1.7 * t)  # to the subject's left
    for way, side in (("OutLeft", 1), ("InRight", 1), ("InLeft", -1), ("OutRight", -1)):
        motion[f"eyeLook{way}"] = np.maximum(0, side * look) + rng.normal(0, 0.01, FRAMES)
    motion = motion.clip(0, 1)
    motion["gaze_left"] = 0.6 * look + rng.normal(0, 0.01, FRAMES)
    for number, name in enumerate(("gaze_up", *HEAD)):
        motion[name] = 0.2 * np.sin((0.6 + 0.1 * number) * t) + rng.normal(0, 0.005, FRAMES)
    valid = np.ones(FRAMES, bool)
    return Take(assemble(np.arange(FRAMES), valid, motion, 0.9, Path("a.csv")), Fraction(30))


@pytest.fixture
def in_the_picture(lively) -> Take:
    """The same with the landmarks of a head that turns and tilts by the take's own angles."""
    yaw, tilt = (lively.motion[name].to_numpy(float) for name in ("head_yaw_left", HEAD[2]))
    turn = np.exp(1j * tilt)  # clockwise in a picture whose y points down
    where = {30: 60 * np.sin(yaw), 0: -70, 16: 70, 36: -45 - 30j, 45: 45 - 30j}
    points = pd.DataFrame(
        0.0,
        index=range(FRAMES),
        columns=[f"{axis}_{point:02d}" for axis in "xy" for point in range(68)],
    )
    for point, at in where.items():
        seen = turn * at
        points[f"x_{point:02d}"], points[f"y_{point:02d}"] = 320 + seen.real, 240 + seen.imag
    return replace(lively, coefficients={"landmarks": points})


def changed(take: Take, **channels) -> Take:
    return replace(take, motion=take.motion.assign(**channels))


def exchanged(take: Take, one: str, other: str) -> Take:
    return changed(take, **{one: take.motion[other], other: take.motion[one]})


def found(take: Take, severity: str = "") -> dict[str, firewall.Finding]:
    return {f.rule: f for f in firewall.examine(take) if severity in ("", f.severity)}


def test_a_take_that_agrees_with_itself_passes_and_could_tell(lively, in_the_picture):
    for take in (lively, in_the_picture, lively.mirrored()):
        assert found(take) == {}
        assert firewall.tells(take) == {"sides_swapped", "eyes_disagree", "angle_unit"}


def test_a_gaze_to_the_wrong_side_fails(lively):
    finding = found(changed(lively, gaze_left=-lively.motion["gaze_left"]), "fail")
    assert set(finding) == {"sides_swapped"}
    assert finding["sides_swapped"].value < -0.9
    detail = finding["sides_swapped"].detail
    assert "gaze_left turns against eyeLookIn and eyeLookOut" in detail
    assert "ingest.mirrored" in detail and "Left and Right" in detail and "sign" in detail


def test_looks_of_exchanged_eyes_fail(lively):
    take = exchanged(lively, "eyeLookInLeft", "eyeLookInRight")
    take = exchanged(take, "eyeLookOutLeft", "eyeLookOutRight")
    assert set(found(take, "fail")) == {"sides_swapped"}


def test_in_and_out_exchanged_in_one_eye_fail(lively):
    take = exchanged(lively, "eyeLookInLeft", "eyeLookOutLeft")
    assert "one eye looks left where the other" in found(take, "fail")["eyes_disagree"].detail


def test_an_eye_that_looks_in_and_out_at_once_fails(lively):
    take = exchanged(lively, "eyeLookOutLeft", "eyeLookOutRight")
    assert "in and out at once" in found(take, "fail")["eyes_disagree"].detail


@pytest.mark.parametrize("angle", ["head_yaw_left", "head_tilt_left"])
def test_a_head_against_its_own_landmarks_fails(in_the_picture, angle):
    take = changed(in_the_picture, **{angle: -in_the_picture.motion[angle]})
    assert found(take, "fail")["sides_swapped"].detail.startswith(f"{angle} turns against")


def test_a_take_that_hardly_moves_is_not_judged(lively):
    quiet = {f"eyeLook{way}": lively.motion[f"eyeLook{way}"] * 0.05 for way in LOOKS}
    take = changed(lively, **quiet, gaze_left=-lively.motion["gaze_left"])
    assert found(take, "fail") == {}
    assert firewall.tells(take) == {"angle_unit"}


def test_degrees_in_a_gaze_are_told_by_the_looks(lively):
    take = changed(lively, gaze_left=np.degrees(lively.motion["gaze_left"]))
    assert "degrees were read as radians" in found(take, "fail")["angle_unit"].detail
    take = changed(lively, gaze_left=np.radians(lively.motion["gaze_left"]))
    assert "radians were read as degrees" in found(take, "fail")["angle_unit"].detail


def test_radians_read_as_degrees_are_told_by_the_landmarks(in_the_picture):
    tilt = np.radians(in_the_picture.motion["head_tilt_left"])
    assert "angle_unit" in found(changed(in_the_picture, head_tilt_left=tilt), "fail")


def test_a_head_beyond_its_neck_fails_with_its_frames(lively):
    pitch = lively.motion["head_pitch_up"].copy()
    pitch[100:230] = 2.5
    finding = found(changed(lively, head_pitch_up=pitch), "fail")["angle_unit"]
    assert (finding.first_frame, finding.last_frame) == (100, 229)
    assert finding.value == pytest.approx(2.5)


def test_a_head_that_turns_away_and_back_is_no_unit(lively):
    yaw = np.radians(95) * np.sin(np.arange(FRAMES) / 10)
    assert found(changed(lively, head_yaw_left=yaw)) == {}


def test_single_glitches_of_the_head_are_no_unit(lively):
    pitch = lively.motion["head_pitch_up"].copy()
    pitch[[50, 90]] = 2.5
    assert found(changed(lively, head_pitch_up=pitch)) == {}


def test_a_head_faster_than_any_fails(lively):
    yaw = lively.motion["head_yaw_left"] + 0.8 * (np.arange(FRAMES) % 2)
    assert "faster than a head can be" in (
        found(changed(lively, head_yaw_left=yaw), "fail")["angle_unit"].detail
    )


def test_a_head_that_does_not_move_at_all_is_noted(lively):
    take = changed(lively, **{name: np.radians(lively.motion[name]) for name in HEAD})
    assert found(take)["still_head"].severity == "note"


def test_a_channel_frozen_at_a_value_is_noted_by_name(lively):
    take = changed(lively, browDownLeft=0.25, jawOpen=0.5, head_yaw_left=0.3, gaze_up=-0.2)
    finding = found(take)["dead_channels"]
    assert finding.severity == "note"
    assert finding.value == 4
    assert sorted(finding.detail.removeprefix("constant: ").split(", ")) == [
        "browDownLeft at 0.25",
        "gaze_up at -0.2",
        "head_yaw_left at 0.3",
        "jawOpen at 0.5",
    ]


def test_a_head_that_is_always_0_is_dead(lively):
    take = changed(lively, **dict.fromkeys(HEAD, 0.0))
    assert found(take)["dead_channels"].value == 3


def test_what_no_action_is_found_by_may_rest_and_a_tracker_need_not_tell_0(lively):
    rest = changed(replace(lively, fps=Fraction(2)), tongueOut=0.0, noseSneerLeft=2e-7)
    assert found(rest) == {}


def test_a_constant_0_is_dead_where_nothing_else_is_ever_0(lively):
    lifted = {name: lively.motion[name] + 0.01 for name in EXPRESSIONS}
    assert "dead_channels" not in found(changed(lively, eyeWideLeft=0.0))
    take = changed(lively, **lifted | {"eyeWideLeft": 0.0})
    assert found(take)["dead_channels"].detail == "constant: eyeWideLeft at 0"


def test_a_constant_0_is_dead_in_a_long_take(lively):
    long = replace(lively, fps=Fraction(2))  # the same frames over two minutes
    assert "dead_channels" in found(changed(long, eyeWideLeft=0.0))


def test_a_channel_that_only_jitters_is_dead_in_a_long_take(lively):
    jitter = 0.3 + np.random.default_rng(1).uniform(0, 0.001, FRAMES)
    assert found(changed(lively, browInnerUp=jitter)) == {}
    long = replace(lively, fps=Fraction(2))
    finding = found(changed(long, browInnerUp=jitter))["dead_channels"]
    assert finding.detail.startswith("constant but for jitter: browInnerUp at 0.3")


def test_a_constant_0_is_not_dead_in_a_short_take(lively):
    lifted = {name: lively.motion[name] + 0.01 for name in EXPRESSIONS}
    take = changed(lively, **lifted | {"eyeWideLeft": 0.0})
    for frames in (30, 60, 149):
        assert found(take.cut(0, frames)) == {}
    assert "dead_channels" in found(take.cut(0, 150))


def test_a_channel_that_is_not_measured_or_hardly_ever_is_not_dead(lively):
    once = pd.Series(np.nan, index=range(FRAMES)).mask(lambda told: told.index == 7, 0.3)
    assert found(changed(lively, eyeWideLeft=np.nan, browInnerUp=once)) == {}


def test_a_result_that_is_repeated_is_noted_with_its_frames(lively):
    motion = lively.motion.copy()
    motion.loc[50:70, list(CHANNELS)] = motion.loc[50, list(CHANNELS)].to_numpy()
    finding = found(replace(lively, motion=motion))["frozen"]
    assert (finding.first_frame, finding.last_frame, finding.value) == (50, 70, 21)


def test_a_short_repetition_is_not_frozen_at_any_rate(lively):
    motion = lively.motion.copy()
    motion.loc[50:53, list(CHANNELS)] = motion.loc[50, list(CHANNELS)].to_numpy()
    for fps in (3, 30):
        assert "frozen" not in found(replace(lively, motion=motion, fps=Fraction(fps)))
    motion.loc[54, list(CHANNELS)] = motion.loc[50, list(CHANNELS)].to_numpy()
    assert "frozen" not in found(replace(lively, motion=motion))
    assert found(replace(lively, motion=motion, fps=Fraction(3)))["frozen"].value == 5


def test_a_take_that_never_changes_is_frozen(lively):
    motion = lively.motion.copy()
    motion.loc[:, list(CHANNELS)] = motion.loc[50, list(CHANNELS)].to_numpy()
    take = replace(lively, motion=motion)
    assert set(found(take)) == {"frozen"}
    assert found(take)["frozen"].value == FRAMES
    assert found(take.cut(0, 14)) == {}
    unmeasured = motion.assign(**dict.fromkeys(CHANNELS, np.nan))
    assert found(replace(lively, motion=unmeasured)) == {}


def test_a_coefficient_out_of_range_is_noted_with_its_worst_value(lively):
    jaw = lively.motion["jawOpen"].copy()
    jaw[10:20] = 1.4
    finding = found(changed(lively, jawOpen=jaw))["out_of_range"]
    assert (finding.first_frame, finding.last_frame) == (10, 19)
    assert finding.value == pytest.approx(1.4)
    assert finding.detail == "jawOpen is outside of 0 to 1 in 4% of the frames"
    jaw[12:] = 0.5  # two frames are under one per cent
    assert found(changed(lively, jawOpen=jaw)) == {}


@pytest.mark.parametrize(
    ("first", "usual", "noted"),
    [(0, 1, True), (1, 1, False), (1, 0, True), (None, 1, False), (3, None, False)],
)
def test_a_first_frame_of_another_number_is_noted(lively, first, usual, noted):
    findings = firewall.examine(replace(lively, first_frame=first), usual)
    assert ["first_frame"] * noted == [finding.rule for finding in findings]


def test_rows_of_zeros_are_lost_frames(lively):
    motion = lively.motion.copy()
    motion.loc[[0, 1, 120], list(EXPRESSIONS)] = 0.0
    flame = pd.DataFrame({"exp000": np.ones(FRAMES)})
    take = firewall.without_lost(replace(lively, motion=motion, coefficients={"flame": flame}))
    assert np.flatnonzero(~take.motion["valid"]).tolist() == [0, 1, 120]
    assert take.motion.loc[[0, 1, 120], [*EXPRESSIONS, *HEAD]].isna().all(axis=None)
    assert take.coefficients["flame"]["exp000"].isna().sum() == 3
    assert take.motion.loc[2:119, "jawOpen"].notna().all()


def test_a_face_at_rest_in_a_take_that_was_made_is_not_lost(lively):
    motion = lively.motion.copy()
    motion.loc[:, list(EXPRESSIONS[5:])] = 0.0  # few channels play
    motion.loc[:60, list(EXPRESSIONS)] = 0.0  # and begin late
    take = replace(lively, motion=motion)
    assert not firewall.lost_frames(take).any()
    assert firewall.without_lost(take) is take


def test_two_eyelids_at_rest_are_no_lost_face(lively):
    unmeasured = dict.fromkeys(EXPRESSIONS[2:], np.nan)
    motion = lively.motion.assign(**unmeasured)
    motion.loc[120, list(EXPRESSIONS[:2])] = 0.0
    assert not firewall.lost_frames(replace(lively, motion=motion)).any()


def test_a_take_of_nothing_but_zeros_and_one_without_expressions_are_not_lost(lively):
    for value in (0.0, np.nan):
        take = changed(lively, **dict.fromkeys(EXPRESSIONS, value))
        assert not firewall.lost_frames(take).any()
        assert "dead_channels" not in found(take)


def test_a_take_without_a_face_is_examined(lively):
    motion = lively.motion.assign(valid=False)
    motion.loc[:, list(CHANNELS)] = np.nan
    assert firewall.examine(replace(lively, motion=motion)) == []
    assert firewall.examine(lively.cut(0, 1)) == firewall.examine(lively.cut(0, 0)) == []


def test_the_ledgers_facts_are_those_of_the_finding(lively):
    finding = found(changed(lively, browDownLeft=0.25))["dead_channels"]
    assert set(finding.facts) == {
        "value",
        "limit",
        "unit",
        "first_frame",
        "last_frame",
        "detail",
    }


def stops(takes: dict[str, Take], format: str = "livelink") -> MimelineError | None:
    examined = {clip: firewall.examine(take) for clip, take in takes.items()}
    able = {clip: firewall.tells(take) for clip, take in takes.items()}
    return firewall.systemic(examined, able, Path("tracks"), format)


def test_one_clip_at_fault_is_its_own_and_most_are_the_set_ups(lively):
    wrong = changed(lively, gaze_left=-lively.motion["gaze_left"])
    quiet = changed(lively, **{f"eyeLook{way}": 0.0 for way in LOOKS})
    assert stops({"a": wrong, "b": wrong}) is None
    assert stops(dict.fromkeys("abc", wrong) | dict.fromkeys("def", lively)) is None
    error = stops(dict.fromkeys("abc", wrong) | {"d": lively} | dict.fromkeys("efghi", quiet))
    assert isinstance(error, BadFile)
    assert error.file == "tracks"
    text = str(error)
    assert "3 of the 4 takes that can tell" in text
    assert "sides_swapped: in a, gaze_left turns against eyeLook" in text
    assert "ingest.format" in text


def test_a_wrong_unit_in_all_clips_names_the_key_that_mends_it(lively):
    takes = {c: changed(lively, gaze_left=np.degrees(lively.motion["gaze_left"])) for c in "abcd"}
    assert "Set ingest.livelink.angle_unit" in str(stops(takes))
    assert "Set ingest.table.angle_unit" in str(stops(takes, "table"))
    assert "ingest.format: table" in str(stops(takes, "pyfeat"))


def test_a_take_counts_once_however_many_of_its_clips_show_the_fault(lively):
    wrong = changed(lively, gaze_left=-lively.motion["gaze_left"])
    assert stops({"cut into ten": wrong} | dict.fromkeys("abcd", lively)) is None
    assert [firewall.of_the_set_up(*n) for n in ((2, 2), (3, 6), (3, 5))] == [False, False, True]


def test_notes_never_stop_a_run(lively):
    assert stops({clip: changed(lively, browDownLeft=0.25) for clip in "abcd"}) is None


def test_clips_that_cannot_be_read_for_one_reason_stop_the_run():
    def refused(remedy: str) -> BadFile:
        return BadFile("x.csv", found="180", expected="half a turn", remedy=remedy)

    unit, cell = (
        refused("Set ingest.livelink.angle_unit: degrees."),
        refused("Set ingest.bad_values: mask."),
    )
    folder = Path("tracks")
    assert firewall.unreadable_alike({"a": unit, "b": unit}, 2, folder) is None
    assert firewall.unreadable_alike(dict.fromkeys("abc", unit), 6, folder) is None
    assert firewall.unreadable_alike(dict.fromkeys("abc", cell), 3, folder) is None
    error = firewall.unreadable_alike(dict.fromkeys("abc", unit) | {"d": cell}, 5, folder)
    assert "3 of 5 takes: found 180 (in x.csv)" in str(error)
    assert "ingest.livelink.angle_unit" in str(error)


LIVELINK = {"fps": "30", "timecode_base": 60, "angle_unit": "radians", "bad_values": "fail"}


@pytest.fixture(scope="module")
def alex(real_data) -> Take:
    return livelink.read(real_data / "arkit_livelink" / "alex_rom_3.csv", **LIVELINK)


def test_real_recordings_pass(alex, real_data):
    assert firewall.examine(alex) == []
    assert firewall.tells(alex) == {"sides_swapped", "eyes_disagree", "angle_unit"}
    assert not firewall.lost_frames(alex).any()
    for frames in (30, 60, 150):
        for start in range(0, len(alex.motion) - frames, 100):
            assert firewall.examine(alex.cut(start, start + frames)) == []
    for path in sorted((real_data / "pyfeat").glob("0*.csv")):
        take = pyfeat.read(path, fps="25", stride=2, bad_values="mask")
        assert firewall.examine(take) == []
        assert not firewall.lost_frames(take).any()
    for path in sorted((real_data / "dreamtalk").glob("*.mat")):
        take = bfm.read(path, fps="25", face=None, bad_values="fail")
        assert firewall.examine(take) == []


def test_real_landmarks_tell_a_swapped_head(real_data, monkeypatch):
    monkeypatch.setattr(detectors, "TURNS", 0.003)  # this head hardly moves
    table = real_data / "openface" / "OpenFace_Test.csv"
    take = openface.read(table, fps="1000", bad_values="fail")
    assert firewall.examine(take, first_frame=1) == []
    assert "sides_swapped" in firewall.tells(take)
    for angle in ("head_yaw_left", "head_tilt_left"):
        finding = found(changed(take, **{angle: -take.motion[angle]}), "fail")["sides_swapped"]
        assert finding.detail.startswith(angle)


def test_faults_planted_in_a_real_recording_are_found(alex):
    for clip in (alex.cut(start, start + 300) for start in (0, 1500, 3000)):
        if "sides_swapped" in firewall.tells(clip):
            wrong = changed(clip, gaze_left=-clip.motion["gaze_left"])
            assert "sides_swapped" in found(wrong, "fail")
    assert "angle_unit" in found(changed(alex, gaze_left=alex.motion["gaze_left"] / 57.3), "fail")


def test_the_toy_world_passes(toy_world):
    passed = 0
    for path in sorted((toy_world.data / "livelink").glob("*.csv")):
        try:
            take = livelink.read(path, **LIVELINK)
        except MimelineError:
            continue  # a planted fault
        assert firewall.examine(take) == []
        assert not firewall.lost_frames(take).any()
        passed += "sides_swapped" in firewall.tells(take)
    assert passed >= 20
