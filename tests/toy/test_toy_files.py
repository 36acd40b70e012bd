import json
import os
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.toy import faults, make, plan
from mimeline.toy.world import render, simulate
from mimeline.vocabulary import EXPRESSIONS

HEADER = (
    "Timecode,BlendShapeCount,EyeBlinkLeft,EyeLookDownLeft,EyeLookInLeft,EyeLookOutLeft,"
    "EyeLookUpLeft,EyeSquintLeft,EyeWideLeft,EyeBlinkRight,EyeLookDownRight,EyeLookInRight,"
    "EyeLookOutRight,EyeLookUpRight,EyeSquintRight,EyeWideRight,JawForward,JawRight,JawLeft,"
    "JawOpen,MouthClose,MouthFunnel,MouthPucker,MouthRight,MouthLeft,MouthSmileLeft,"
    "MouthSmileRight,MouthFrownLeft,MouthFrownRight,MouthDimpleLeft,MouthDimpleRight,"
    "MouthStretchLeft,MouthStretchRight,MouthRollLower,MouthRollUpper,MouthShrugLower,"
    "MouthShrugUpper,MouthPressLeft,MouthPressRight,MouthLowerDownLeft,MouthLowerDownRight,"
    "MouthUpperUpLeft,MouthUpperUpRight,BrowDownLeft,BrowDownRight,BrowInnerUp,BrowOuterUpLeft,"
    "BrowOuterUpRight,CheekPuff,CheekSquintLeft,CheekSquintRight,NoseSneerLeft,NoseSneerRight,"
    "TongueOut,HeadYaw,HeadPitch,HeadRoll,LeftEyeYaw,LeftEyePitch,LeftEyeRoll,RightEyeYaw,"
    "RightEyePitch,RightEyeRoll"
)
ROW = re.compile(r"\d\d:\d\d:\d\d:\d\d\.\d{3},61(,-?\d\.\d{10}){61}")
REAL = Path(os.environ.get("MIMELINE_REAL_DATA", Path(__file__).parents[3] / "shared" / "data"))


@pytest.fixture(scope="module")
def planted(written) -> pd.DataFrame:
    return pd.read_csv(written.truth / "faults.csv")


@pytest.fixture(scope="module")
def info(written) -> dict:
    return json.loads((written.data / "celebvtext_info.json").read_text())


@pytest.fixture(scope="module")
def acts(written) -> dict:
    return json.loads((written.data / "annotations.json").read_text())["act"]


@pytest.fixture(scope="module")
def motion() -> pd.DataFrame:
    """What the files of the written world ought to hold."""
    crowd = plan.people(8, 3)
    planned = plan.clips(40, crowd, 3)
    planted = faults.spread(40, np.random.default_rng([3, 5]), filmed=True)
    planned = [planted[i].planned(c) if i in planted else c for i, c in enumerate(planned)]
    return render(planned, crowd, 3).motion


def clip_with(planted: pd.DataFrame, fault: str) -> str:
    return planted.set_index("fault").at[fault, "clip_id"]


VIDEO = {"video_share": 0.15, "video_px": 64}  # as the written world has it


def take(data: Path, clip_id: str) -> list[str]:
    return (data / "livelink" / f"{clip_id}.csv").read_text().splitlines()


def ticks(lines: list[str]) -> np.ndarray:
    """Timecodes in 60ths."""
    parts = np.array([re.split("[:,]", line)[:4] for line in lines[1:]], dtype=float)
    return parts @ [60 * 3600, 60 * 60, 60, 1]


def sound(written, planted) -> list[str]:
    spoilt = set(planted["clip_id"])
    return [p.stem for p in (written.data / "livelink").iterdir() if p.stem not in spoilt]


def test_takes_have_the_header_and_the_rows_of_real_takes(written, planted):
    for clip_id in sound(written, planted):
        header, *rows = take(written.data, clip_id)
        assert header == HEADER
        assert all(ROW.fullmatch(row) for row in rows)


def test_the_real_take_has_that_header_and_such_rows_too():
    real = REAL / "arkit_livelink" / "alex_rom_3.csv"
    if not real.exists():
        pytest.skip(f"no real take at {real}")
    header, *rows = real.read_text().splitlines()
    assert header == HEADER
    assert all(ROW.fullmatch(row) for row in rows)


def test_takes_parse_back_to_the_motion_within_the_written_decimals(written, planted, motion):
    for clip_id in sound(written, planted):
        rows = pd.read_csv(written.data / "livelink" / f"{clip_id}.csv")
        wanted = motion[motion["clip_id"] == clip_id].reset_index(drop=True)
        read = {name: rows[name[0].upper() + name[1:]] for name in EXPRESSIONS}
        read |= {
            "head_yaw_left": -rows["HeadYaw"],
            "head_pitch_up": -rows["HeadPitch"],
            "head_tilt_left": rows["HeadRoll"],
            "gaze_left": -(rows["LeftEyeYaw"] + rows["RightEyeYaw"]) / 2,
            "gaze_up": -(rows["LeftEyePitch"] + rows["RightEyePitch"]) / 2,
        }
        for name, values in read.items():
            np.testing.assert_allclose(values, wanted[name].astype(float), rtol=0, atol=6e-11)


def test_timecode_counts_two_60ths_a_frame_and_passes_minutes(written, planted):
    for clip_id in sound(written, planted):
        steps = np.diff(ticks(take(written.data, clip_id)))
        assert np.abs(steps - 2).max() < 0.01


def test_the_same_seed_writes_the_same_bytes(written, tmp_path):
    make(tmp_path / "data", tmp_path / "truth", 8, 40, 3, **VIDEO)
    for name in ("data", "truth"):
        for path in sorted((tmp_path / name).rglob("*")):
            if path.is_file():
                twin = written.root / path.relative_to(tmp_path)
                assert path.read_bytes() == twin.read_bytes(), path.name


def test_every_fault_is_listed_once_with_what_ought_to_happen(planted):
    assert planted["clip_id"].is_unique
    named = ["listed_twice", *(fault.name for fault in faults.FAULTS)]
    assert sorted(planted["fault"]) == sorted(named)
    assert set(planted["status"]) == {"kept", "dropped", "failed"}
    assert len(planted) == 21


def test_a_clip_that_is_listed_twice_has_two_names_and_nothing_else_apart(planted, info):
    again = f"{clip_with(planted, 'listed_twice')}.mp4"
    assert again.endswith("_1.mp4")
    assert info[again] == info[again.replace("_1.mp4", "_0.mp4")]


def test_clips_too_short_and_too_long_are_so(planted, info):
    lasts = {
        key.removesuffix(".mp4"): clip["duration"]["end_sec"] - clip["duration"]["start_sec"]
        for key, clip in info.items()
    }
    assert lasts.pop(clip_with(planted, "too_short")) < 5
    assert lasts.pop(clip_with(planted, "too_long")) > 10
    assert all(5 <= seconds <= 10 for seconds in lasts.values())


def test_excluded_actions_stand_in_the_catalogue_of_their_clips_alone(planted, acts):
    unwanted = {"turn", "shake_head", "head_wagging"}
    named = {clip: {act[0] for act in said} & unwanted for clip, said in acts.items()}
    guilty = set(planted.loc[planted["fault"] == "excluded_action", "clip_id"])
    assert {clip for clip, names in named.items() if names} == guilty
    assert set().union(*named.values()) == unwanted


def test_one_face_crop_is_too_small(planted, info):
    sides = {
        key.removesuffix(".mp4"): min(b["bottom"] - b["top"], b["right"] - b["left"])
        for key, b in ((key, clip["bbox"]) for key, clip in info.items())
    }
    assert [c for c, s in sides.items() if s < 512] == [clip_with(planted, "too_small")]


def test_one_head_turns_past_35_degrees_and_the_others_stay_clear_of_it(written, planted):
    pose = pd.read_csv(written.data / "head_pose.csv")
    largest = pose["yaw"].abs().groupby(pose["clip_id"]).max()
    assert largest.pop(clip_with(planted, "turned")) > 40
    assert largest.max() < 34


def test_a_lost_tracker_leaves_out_more_than_a_tenth_and_another_a_few_rows(
    written, planted, motion
):
    for fault, low, high in (("tracking_lost", 0.1, 0.5), ("rows_absent", 0.01, 0.1)):
        clip_id = clip_with(planted, fault)
        frames = (motion["clip_id"] == clip_id).sum()
        lines = take(written.data, clip_id)
        assert low < 1 - (len(lines) - 1) / frames < high
        steps = np.diff(ticks(lines))
        assert round(steps.sum() / 2) == frames - 1  # the first and the last row are there
        assert (steps > 3).sum() == 1


def test_broken_takes_are_broken_as_listed(written, planted):
    assert take(written.data, clip_with(planted, "no_header"))[0][0].isdigit()
    for fault, text in (("text_cell", "n/a"), ("nan_cell", "nan")):
        cells = [c for row in take(written.data, clip_with(planted, fault)) for c in row.split(",")]
        assert cells.count(text) == 1
    missing = clip_with(planted, "missing_file")
    assert not (written.data / "livelink" / f"{missing}.csv").exists()


def test_an_id_may_begin_with_a_dash(written, planted, info):
    clip_id = clip_with(planted, "leading_dash")
    assert clip_id.startswith("-")
    assert info[f"{clip_id}.mp4"]["ytb_id"] == clip_id[:11]
    assert len(take(written.data, clip_id)) > 150


def test_the_hostile_id_writes_nothing_outside_its_folder(written, planted, info):
    assert clip_with(planted, "unsafe_id") == "../../outside"
    assert "../../outside.mp4" in info
    assert {p.name for p in written.root.parent.iterdir()} == {"root"}
    assert {p.name for p in written.root.iterdir()} == {"data", "truth"}
    assert not [p for p in written.root.rglob("*") if "outside" in p.name]


def test_several_clips_share_a_source_and_several_sources_a_person(info):
    clips = pd.DataFrame([(c["ytb_id"], c["subject"]) for c in info.values()], columns=["s", "p"])
    assert clips["s"].value_counts().max() > 1
    assert clips.groupby("p")["s"].nunique().max() > 1
    assert clips.groupby("s")["p"].nunique().max() == 1


def test_catalogue_seconds_round_to_the_takes_frames(written, planted, info):
    for clip_id in sound(written, planted):
        lasts = info[f"{clip_id}.mp4"]["duration"]
        frames = (lasts["end_sec"] - lasts["start_sec"]) * 30
        assert abs(frames - (len(take(written.data, clip_id)) - 1)) < 0.5


def test_annotations_are_whole_seconds_of_the_source_not_always_padded(acts, info):
    texts = []
    for clip_id, said in acts.items():
        lasts = info[f"{clip_id}.mp4"]["duration"]
        for _, (begins, ends, seconds, order) in said:
            first, last = (
                np.dot([3600, 60, 1], [int(p) for p in t.split(":")]) for t in (begins, ends)
            )
            assert last - first == seconds > 0
            assert int(lasts["start_sec"]) <= first
            assert last <= lasts["end_sec"] + 1
            assert order >= 0
            texts.append(begins)
    assert any(re.fullmatch(r"\d:\d\d:\d\d", t) for t in texts)
    assert any(re.search(r":\d(:|$)", t) for t in texts)


def test_head_poses_are_in_degrees_and_in_the_signs_of_6drepnet(written, motion):
    pose = pd.read_csv(written.data / "head_pose.csv").merge(motion, on=["clip_id", "frame"])
    for column, name, sign in (
        ("yaw", "head_yaw_left", -1),
        ("pitch", "head_pitch_up", 1),
        ("roll", "head_tilt_left", 1),
    ):
        assert np.abs(pose[column] - sign * np.degrees(pose[name])).max() < 5


def test_truth_covers_every_clip_with_a_name_that_a_file_can_have(written, planted, info):
    frames = tables.read(tables.FRAMES, written.truth / "frames.parquet")
    intervals = tables.read(tables.INTERVALS, written.truth / "intervals.parquet")
    named = {key.removesuffix(".mp4") for key in info}
    named -= {"../../outside", clip_with(planted, "listed_twice")}
    assert set(frames["clip_id"]) == named
    assert set(intervals["clip_id"]) <= named
    assert set(intervals["source"]) == {"human"}


def test_a_small_world_keeps_half_of_its_clips_sound(tmp_path):
    make(tmp_path / "data", tmp_path / "truth", 3, 6, 0, video_share=0, video_px=64)
    planted = pd.read_csv(tmp_path / "truth" / "faults.csv")
    assert (planted["fault"] != "listed_twice").sum() == 3


def test_the_habit_of_frowning_smiles_is_written_as_well(tmp_path):
    make(tmp_path / "data", tmp_path / "truth", 4, 24, 3, 0, 64, smiles_frown=0.9)
    written = tables.read(tables.FRAMES, tmp_path / "truth" / "frames.parquet")
    acted = simulate(4, 24, 3, smiles_frown=0.9).frames
    planted = set(pd.read_csv(tmp_path / "truth" / "faults.csv")["clip_id"])
    sound = (set(written["clip_id"]) & set(acted["clip_id"])) - planted
    ours, theirs = (
        rows[rows["clip_id"].isin(sound)].reset_index(drop=True) for rows in (written, acted)
    )
    pd.testing.assert_frame_equal(ours, theirs, check_dtype=False)
    smiling = ours["Smile"] | ours["SoftSmile"]
    assert ours.loc[smiling, "BrowDown"].mean() > 0.75
