import contextlib

import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.clips.pose import compared, mask_turned, pose
from mimeline.errors import BadFile, MimelineError
from mimeline.tracking.formats import livelink
from mimeline.tracking.formats.sixdrepnet import read_sixdrepnet


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
        poses: list[tuple], tracked: pd.DataFrame | None = None, source: str | None = None
    ) -> pd.DataFrame:
        names = ["a"] if tracked is None else sorted(set(tracked["clip_id"]))
        clips = pd.DataFrame({"clip_id": names}).reindex(columns=tables.CLIPS.schema.names)
        clips = clips.assign(
            source_id=source or clips["clip_id"], start_s=0.0, end_s=4.0, shard=0, n_frames=100
        )
        for name in ("actions", "emotions", "attributes", "texts"):
            clips[name] = [[]] * len(names)
        tables.write(tables.CLIPS, clips, tmp_path / "clips.parquet")
        motion = tables.empty(tables.MOTION)
        if tracked is not None:
            motion = tracked.assign(valid=True).reindex(columns=tables.MOTION.schema.names)
        tables.write(tables.MOTION, motion, tmp_path / "motion.parquet", reason="none is tracked")
        table = pd.DataFrame(poses, columns=["clip_id", "frame", "pitch", "yaw", "roll"])
        table.to_csv(tmp_path / "pose.csv", index=False)
        out = tmp_path / "kept.parquet", tmp_path / "ledger.parquet"
        paths = tmp_path / "clips.parquet", tmp_path / "motion.parquet", tmp_path
        pose(*paths, *out, format="sixdrepnet", options={"file": "pose.csv"}, max_yaw_deg=35.0)
        return tables.read(tables.LEDGER, out[1])

    return run


def test_a_turn_outside_of_the_clip_does_not_count_and_the_ledger_says_what_was_seen(run):
    row = run([("a", frame, 0, 90 if frame >= 100 else 0, 0) for frame in range(50, 150)]).iloc[0]
    assert row["status"] == "kept"
    assert row["detail"] == "applied to the 50 of 100 frames with a head angle"


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
