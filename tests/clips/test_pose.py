import contextlib

import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.clips.pose import compared, mask_turned, pose
from mimeline.errors import BadFile, MimelineError
from mimeline.face.rotations import turned
from mimeline.tracking.formats import livelink, openface
from mimeline.tracking.formats.sixdrepnet import read_sixdrepnet
from mimeline.vocabulary import HEAD


def angles(clips: dict[str, list[float]]) -> pd.DataFrame:
    rows = [(c, f, np.radians(yaw)) for c, yaws in clips.items() for f, yaw in enumerate(yaws)]
    return pd.DataFrame(rows, columns=["clip_id", "frame", "head_yaw_left"])


def test_a_turn_to_either_side_is_found_with_its_frames():
    turned = mask_turned(
        angles({"still": [0, 34.9], "left": [0, 36, 40, 10], "right": [-36, 0, 0, 0]}),
        max_yaw=np.radians(35),
    ).set_index("clip_id")
    assert turned.index.tolist() == ["left", "right"]
    assert turned.loc["left", ["first_frame", "last_frame"]].tolist() == [1, 2]
    assert np.degrees(turned.loc["left", "value"]) == pytest.approx(40)


@pytest.fixture
def run(tmp_path):
    def run(
        poses: list[tuple] | None,
        tracked: pd.DataFrame | None = None,
        source: str | None = None,
        format: str = "sixdrepnet",
        start_s: float = 0.0,
    ) -> pd.DataFrame:
        names = ["a"] if tracked is None else sorted(set(tracked["clip_id"]))
        clips = pd.DataFrame({"clip_id": names}).reindex(columns=tables.CLIPS.schema.names)
        clips = clips.assign(
            source_id=source or clips["clip_id"],
            start_s=start_s,
            end_s=start_s + 4.0,
            fps_num=25,
            fps_den=1,
            n_frames=100,
            shard=0,
        )
        for name in ("actions", "emotions", "attributes", "texts"):
            clips[name] = [[]] * len(names)
        tables.write(tables.CLIPS, clips, tmp_path / "clips.parquet")
        motion = tables.empty(tables.MOTION)
        if tracked is not None:
            motion = tracked.assign(valid=True).reindex(columns=tables.MOTION.schema.names)
        tables.write(tables.MOTION, motion, tmp_path / "motion.parquet", reason="none is tracked")
        file = "poses"  # a folder that the test fills
        if poses is not None:
            file = "pose.csv"
            table = pd.DataFrame(poses, columns=["clip_id", "frame", "pitch", "yaw", "roll"])
            table.to_csv(tmp_path / file, index=False)
        out = tmp_path / "kept.parquet", tmp_path / "ledger.parquet"
        paths = tmp_path / "clips.parquet", tmp_path / "motion.parquet", tmp_path
        pose(*paths, *out, format=format, options={"file": file}, max_yaw_deg=35.0)
        return tables.read(tables.LEDGER, out[1])

    return run


def test_a_turn_outside_of_the_clip_does_not_count_and_the_ledger_says_what_was_seen(run):
    row = run([("a", frame, 0, 90 if frame >= 100 else 0, 0) for frame in range(50, 150)]).iloc[0]
    assert row["status"] == "kept"
    assert row["detail"].startswith("applied to the 50 of 100 frames with a head angle; ")
    assert "goes on to frame 149, the clip has 100" in row["detail"]


def test_a_clip_without_an_angle_is_kept_with_a_note(run):
    row = run([("other", 0, 0, 90, 0), ("a", 9000, 0, 90, 0)]).iloc[0]
    assert row["status"] == "kept"
    assert row["detail"].startswith("not applied")


def test_a_clip_that_turns_is_dropped_with_its_frames(run):
    row = run([("a", frame, 0, -40 if 20 <= frame < 30 else 0, 0) for frame in range(100)]).iloc[0]
    assert row[["status", "rule", "first_frame", "last_frame"]].tolist() == [
        "dropped",
        "turned",
        20,
        29,
    ]
    assert row["value"] == pytest.approx(40)


def swings(clips: str, yaw: float = 0.3, tilt: float = 0.2) -> pd.DataFrame:
    """Motion of clips that turn and tilt to and fro, to so many radians."""
    frame = np.arange(100)
    parts = [
        pd.DataFrame(
            {
                "clip_id": clip,
                "frame": frame,
                "head_yaw_left": yaw * np.sin(frame / 9),
                "head_pitch_up": 0.0,
                "head_tilt_left": tilt * np.sin(frame / 7),
            }
        )
        for clip in clips
    ]
    return pd.concat(parts)


def poses(motion: pd.DataFrame, noise: float = 1.0) -> list[tuple]:
    """What 6DRepNet says of them, in degrees and its own signs."""
    yaw, tilt = -np.degrees(motion["head_yaw_left"]), np.degrees(motion["head_tilt_left"])
    yaw = yaw + np.random.default_rng(0).normal(0, noise, len(yaw))
    rows = zip(motion["clip_id"], motion["frame"], yaw, tilt, strict=True)
    return [(clip, frame, 0.0, y, t) for clip, frame, y, t in rows]


def test_a_pose_table_that_agrees_with_the_tracker_is_not_mentioned(run):
    tracked = swings("abc")
    assert run(poses(tracked), tracked)["rule"].isna().all()


def test_a_clip_that_turns_against_the_tracker_is_noted(run):
    tracked = swings("abc")
    seen = poses(pd.concat([swings("a", yaw=-0.3), swings("bc")]))
    ledger = run(seen, tracked).set_index("clip_id")
    assert ledger["rule"].notna().tolist() == [True, False, False]
    assert ledger.loc["a", "status"] == "kept"
    assert ledger.loc["a", "rule"] == "pose_disagrees"
    assert ledger.loc["a", "value"] < -0.9
    assert ledger.loc["a", "detail"].startswith("head_yaw_left: ")


@pytest.mark.parametrize(("yaw", "tilt"), [(-0.3, 0.2), (0.3, -0.2)])
def test_most_clips_that_turn_against_the_tracker_stop_the_run(run, yaw, tilt):
    with pytest.raises(BadFile, match=r"pose.csv, 3 of the 4 sources.*ingest.mirrored") as error:
        run(poses(pd.concat([swings("abc", yaw, tilt), swings("d")])), swings("abcd"))
    assert ("head_yaw_left" if yaw < 0 else "head_tilt_left") in error.value.found


def test_clips_of_one_source_are_one(run):
    tracked = swings("abcdefghij")
    assert (run(poses(swings("abcdefghij", yaw=-0.3)), tracked, "s")["status"] == "kept").all()


def test_two_clips_or_clips_that_hardly_move_stop_no_run(run):
    assert len(run(poses(swings("ab", yaw=-0.3)), swings("ab"))) == 2
    still = {"yaw": 0.02, "tilt": 0.0}
    assert (
        run(poses(swings("abc", yaw=-0.02, tilt=0.0)), swings("abc", **still))["rule"].isna().all()
    )


@pytest.mark.parametrize("at_fault", ["table", "tracker"])
def test_angles_of_another_unit_stop_the_run(run, at_fault):
    in_radians, tracked = np.pi / 180, swings("abc")
    rows = poses(tracked, noise=0.1)
    if at_fault == "table":
        rows = [(clip, f, 0.0, y * in_radians, t * in_radians) for clip, f, _, y, t in rows]
    else:
        tracked = swings("abc", yaw=0.3 * in_radians, tilt=0.2 * in_radians)
    with pytest.raises(BadFile, match="angles in degrees") as error:
        run(rows, tracked)
    assert "3 of the 3 sources" in error.value.place


def test_a_clip_with_angles_of_another_unit_is_noted(run):
    tracked = swings("abc")
    rows = [
        (clip, f, 0.0, y * (np.pi / 180 if clip == "a" else 1), t)
        for clip, f, _, y, t in poses(tracked, noise=0.1)
    ]
    ledger = run(rows, tracked).set_index("clip_id")
    assert ledger["rule"].notna().tolist() == [True, False, False]
    assert ledger.loc["a", "value"] == pytest.approx(np.pi / 180, rel=0.1)
    assert "head_yaw_left" in ledger.loc["a", "detail"]


@pytest.fixture
def folder(tmp_path):
    folder = tmp_path / "poses"
    folder.mkdir()
    return folder


def test_a_folder_holds_a_table_for_each_clip_with_or_without_frames(run, folder):
    turning = np.where(np.arange(100) >= 90, -40.0, 0.0)
    told = pd.DataFrame({" Pitch": 0.0, "YAW": turning, "roll ": 1.0})
    told.to_csv(folder / "a.csv", index_label="")
    told.assign(frame=np.arange(100) + 50).to_csv(folder / "b.csv", index=False)
    tracked = swings("abc", yaw=0.01, tilt=0.01)
    ledger = run(None, tracked).set_index("clip_id")
    assert ledger["status"].tolist() == ["dropped", "kept", "kept"]
    assert ledger.loc["a", "first_frame"] == 90
    assert ledger.loc["b", "detail"].startswith("applied to the 50 of 100 frames")
    assert ledger.loc["c", "detail"].endswith("there is no c.csv in poses, nor c.csv")


def openface_table(motion: pd.DataFrame, success=1) -> pd.DataFrame:
    """What OpenFace says of a head's motion, frames counted from 1."""
    back = np.diag([1.0, -1.0, -1.0])  # to the camera's axes, in which R = Rx Ry Rz
    turns = back @ turned(*motion[list(HEAD)].to_numpy(float).T) @ back  # (n, 3, 3)
    return pd.DataFrame(
        {
            "frame": np.arange(1, len(motion) + 1),
            " confidence": 0.98,
            " success": success,
            " pose_Rx": np.arctan2(-turns[:, 1, 2], turns[:, 2, 2]),
            " pose_Ry": np.arcsin(turns[:, 0, 2]),
            " pose_Rz": np.arctan2(-turns[:, 0, 1], turns[:, 0, 0]),
        }
    )


def test_openface_tables_turn_the_way_the_tracker_does(run, folder):
    tracked = swings("abcd")
    for clip, motion in tracked.groupby("clip_id"):
        openface_table(motion).to_csv(folder / f"{clip}.csv", index=False)
    assert run(None, tracked, format="openface")["rule"].isna().all()
    for clip, motion in swings("abc", yaw=-0.3).groupby("clip_id"):
        openface_table(motion).to_csv(folder / f"{clip}.csv", index=False)
    with pytest.raises(BadFile, match=r"3 of the 4 sources.*head_yaw_left"):
        run(None, tracked, format="openface")


def test_openface_in_degrees_is_refused(run, folder):
    for clip, motion in swings("abc").groupby("clip_id"):
        table = openface_table(motion)
        table[[" pose_Rx", " pose_Ry", " pose_Rz"]] *= 180 / np.pi
        table.to_csv(folder / f"{clip}.csv", index=False)
    with pytest.raises(BadFile, match="angles within half a turn"):
        run(None, swings("abc"), format="openface")


def test_frames_without_success_are_unknown_and_not_ahead(run, folder):
    motion = swings("a").assign(head_yaw_left=0.8)
    table = openface_table(motion, success=(np.arange(100) >= 60).astype(int))
    table.loc[:59, " pose_Ry"] = 0.0
    table[" pose_Ry"] = table[" pose_Ry"].astype(object)
    table.loc[70, " pose_Ry"] = "-nan(ind)"
    table.to_csv(folder / "a.csv", index=False)
    assert openface.read_head(folder / "a.csv")["head_yaw_left"].isna().sum() == 61
    row = run(None, format="openface").iloc[0]
    assert row[["status", "first_frame", "last_frame"]].tolist() == ["dropped", 60, 99]
    table.assign(**{" success": 0}).to_csv(folder / "a.csv", index=False)
    row = run(None, format="openface").iloc[0]
    assert row["status"] == "kept"
    assert row["detail"].startswith("not applied")


def test_of_a_sources_table_the_clips_seconds_are_taken(run, folder):
    frame = np.arange(500)
    yaw = np.where((frame >= 210) & (frame < 220), 0.7, 0.0)
    whole = pd.DataFrame(0.0, index=frame, columns=list(HEAD)).assign(head_yaw_left=yaw)
    openface_table(whole).to_csv(folder / "film.csv", index=False)
    row = run(None, source="film", format="openface", start_s=8.0).iloc[0]
    assert row[["status", "first_frame", "last_frame"]].tolist() == ["dropped", 10, 19]
    row = run(None, source="film", format="openface", start_s=12.0).iloc[0]
    assert row["status"] == "kept"
    assert pd.isna(row["rule"])
    row = run(None, source="film", format="openface", start_s=18.0).iloc[0]
    assert row["detail"] == "applied to the 50 of 100 frames with a head angle"


def test_one_openface_table_of_all_clips_tells_them_apart(run, tmp_path, folder):
    tracked = swings("abc")
    parts = [
        openface_table(motion).assign(clip_id=clip) for clip, motion in tracked.groupby("clip_id")
    ]
    folder.rmdir()
    pd.concat(parts).to_csv(tmp_path / "poses", index=False)
    assert run(None, tracked, format="openface")["rule"].isna().all()


def test_of_several_faces_the_surest_turns(run, folder):
    ahead = openface_table(swings("a").assign(head_yaw_left=0.0)).assign(face_id=0)
    aside = openface_table(swings("a").assign(head_yaw_left=0.9)).assign(face_id=1)
    for sure, status in ((ahead, "kept"), (aside, "dropped")):
        faces = pd.concat([ahead, aside])
        faces[" confidence"] = np.where(faces["face_id"] == sure["face_id"].iloc[0], 0.9, 0.5)
        faces.to_csv(folder / "a.csv", index=False)
        assert run(None, format="openface")["status"].tolist() == [status]


@pytest.mark.parametrize("format", ["sixdrepnet", "openface"])
def test_a_missing_folder_names_the_key(run, format):
    with pytest.raises(BadFile, match=rf"pose\.{format}\.file"):
        run(None, format=format)


def test_a_broken_table_of_one_clip_is_a_remark_and_of_most_an_error(run, folder):
    tracked = swings("abcd")
    for clip, motion in tracked.groupby("clip_id"):
        openface_table(motion).to_csv(folder / f"{clip}.csv", index=False)
    (folder / "a.csv").write_text("<!DOCTYPE html>\n")
    ledger = run(None, tracked, format="openface").set_index("clip_id")
    assert ledger.loc["a", "detail"].startswith("not applied")
    assert "a.csv" in ledger.loc["a", "detail"]
    assert ledger.loc[["b", "c", "d"], "rule"].isna().all()
    for clip in "bc":
        (folder / f"{clip}.csv").write_text("")
    with pytest.raises(BadFile):
        run(None, tracked, format="openface")


def test_a_real_openface_table_gives_the_head_that_its_take_has(real_data, run, folder):
    path = real_data / "openface" / "OpenFace_Test.csv"
    take = openface.read(path, "fail", "30").motion
    angles = openface.read_head(path).set_index("frame").reindex(take["frame"])
    for name in HEAD:
        assert np.allclose(angles[name], take[name], atol=1e-6, equal_nan=True)
    (folder / "a.csv").write_bytes(path.read_bytes())
    row = run(None, take[["frame", *HEAD]].assign(clip_id="a"), format="openface").iloc[0]
    assert row["status"] == "kept"


def test_the_toy_worlds_two_sources_of_the_head_agree(toy_world):
    takes = []
    for path in sorted((toy_world.data / "livelink").glob("*.csv")):
        with contextlib.suppress(MimelineError):  # a planted fault
            options = {"fps": "30", "timecode_base": 60, "angle_unit": "radians"}
            take = livelink.read(path, bad_values="mask", **options)
            takes.append(take.motion.assign(clip_id=path.stem))
    angles = read_sixdrepnet(toy_world.data / "head_pose.csv")
    agreement = compared(pd.concat(takes), angles)
    assert agreement["clip_id"].nunique() > 20
    assert agreement["r"].min() > 0.9
