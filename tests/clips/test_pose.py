import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.clips.pose import mask_turned, pose


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
    def run(poses: list[tuple]):
        clips = pd.DataFrame([{"clip_id": "a", "n_frames": 100}], columns=tables.CLIPS.schema.names)
        clips = clips.assign(source_id="s", start_s=0.0, end_s=4.0, shard=0, n_frames=100)
        clips["actions"], clips["texts"] = [[]], [[]]
        tables.write(tables.CLIPS, clips.assign(clip_id="a"), tmp_path / "clips.parquet")
        table = pd.DataFrame(poses, columns=["clip_id", "frame", "pitch", "yaw", "roll"])
        table.to_csv(tmp_path / "pose.csv", index=False)
        out = tmp_path / "kept.parquet", tmp_path / "ledger.parquet"
        paths = tmp_path / "clips.parquet", tmp_path / "motion.parquet", tmp_path
        pose(*paths, *out, format="sixdrepnet", options={"file": "pose.csv"}, max_yaw_deg=35.0)
        return tables.read(tables.LEDGER, out[1]).iloc[0]

    return run


def test_a_turn_outside_of_the_clip_does_not_count_and_the_ledger_says_what_was_seen(run):
    row = run([("a", frame, 0, 90 if frame >= 100 else 0, 0) for frame in range(50, 150)])
    assert row["status"] == "kept"
    assert row["detail"] == "applied to the 50 of 100 frames with a head angle"


def test_a_clip_without_an_angle_is_kept_with_a_note(run):
    row = run([("other", 0, 0, 90, 0), ("a", 9000, 0, 90, 0)])
    assert row["status"] == "kept"
    assert row["detail"].startswith("not applied")


def test_a_clip_that_turns_is_dropped_with_its_frames(run):
    row = run([("a", frame, 0, -40 if 20 <= frame < 30 else 0, 0) for frame in range(100)])
    assert row[["status", "rule", "first_frame", "last_frame"]].tolist() == [
        "dropped",
        "turned",
        20,
        29,
    ]
    assert row["value"] == pytest.approx(40)
