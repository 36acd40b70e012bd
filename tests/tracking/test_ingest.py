import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.errors import MimelineError
from mimeline.tracking.ingest import ingest
from mimeline.vocabulary import EXPRESSIONS

GOLDEN = Path(__file__).parent / "golden"
OPTIONS = {"folder": ".", "fps": "30", "timecode_base": 60, "angle_unit": "radians"}


def clips_table(rows: list[dict]) -> pd.DataFrame:
    table = pd.DataFrame(rows, columns=tables.CLIPS.schema.names)
    for name in ("actions", "emotions", "attributes", "texts"):
        table[name] = [[]] * len(table)
    return table.assign(shard=0)


@pytest.fixture
def run(tmp_path):
    def run(clips: list[dict], **keys):
        tables.write(tables.CLIPS, clips_table(clips), tmp_path / "clips.parquet")
        out = {n: tmp_path / f"{n}.parquet" for n in ("motion", "origins", "kept", "ledger")}
        out["coefficients"] = [tmp_path / f"{name}.parquet" for name in tables.COEFFICIENTS]
        defaults = {"format": "livelink", "options": OPTIONS, "bad_values": "fail"}
        limits = {"max_missing": 0.3, "max_loss": None, "max_reprojection": 0.1}
        keys = defaults | {"mirrored": False} | limits | keys
        ingest(tmp_path / "clips.parquet", tmp_path, **out, **keys)
        return (
            tables.read(tables.MOTION, out["motion"]),
            tables.read(tables.CLIPS, out["kept"]),
            tables.read(tables.LEDGER, out["ledger"]).set_index("clip_id"),
        )

    return run


def clip(clip_id: str, start_s: float, end_s: float, source_id: str = "source") -> dict:
    return {"clip_id": clip_id, "source_id": source_id, "start_s": start_s, "end_s": end_s}


def noted(ledger: pd.DataFrame, clip_id: str, rule: str) -> pd.Series:
    """The one note of a rule on a clip that is kept."""
    rows = ledger[(ledger.index == clip_id) & (ledger["rule"] == rule)]
    assert rows["status"].tolist() == ["kept"]
    return rows.iloc[0]


def test_a_clip_has_its_own_result_and_its_frame_clock(run, livelink_rows, tmp_path):
    livelink_rows.to_csv(tmp_path / "a.csv", index=False)
    motion, kept, ledger = run([clip("a", 7.0, 7.0 + 5 / 30)])
    assert motion["frame"].tolist() == [0, 1, 2, 3, 4]
    assert kept[["fps_num", "fps_den", "n_frames"]].iloc[0].tolist() == [30, 1, 5]
    assert noted(ledger, "a", "masked")["first_frame"] == 3


def test_a_part_of_a_longer_take_is_cut_out_by_its_seconds(run, livelink_rows, tmp_path):
    livelink_rows.to_csv(tmp_path / "source.csv", index=False)
    motion, _, _ = run([clip("s_0", 0, 2 / 30), clip("s_1", 2 / 30, 5 / 30)], max_missing=0.5)
    assert motion.groupby("clip_id")["frame"].apply(list).to_dict() == {
        "s_0": [0, 1],
        "s_1": [0, 1, 2],
    }
    second = motion[motion["clip_id"] == "s_1"]
    assert second["jawOpen"].iloc[0] == pytest.approx(livelink_rows["JawOpen"].iloc[2])


def test_a_clip_that_the_tracker_lost_is_dropped_with_its_frames(run, livelink_rows, tmp_path):
    livelink_rows.to_csv(tmp_path / "a.csv", index=False)
    motion, kept, ledger = run([clip("a", 0, 10 / 30)])  # the result ends after half of the clip
    assert motion.empty
    assert kept.empty
    row = ledger.loc["a"]
    assert row[["status", "rule", "last_frame"]].tolist() == ["dropped", "tracking_lost", 8]
    assert row["value"] == pytest.approx(5 / 9)


def test_a_result_longer_than_its_clip_fails(run, livelink_rows, tmp_path):
    livelink_rows.to_csv(tmp_path / "a.csv", index=False)  # five frames
    _, kept, ledger = run([clip("a", 0, 2 / 30)])
    assert kept.empty
    assert ledger.loc["a", ["status", "rule", "value"]].tolist() == [
        "failed",
        "longer_than_clip",
        5,
    ]


def test_a_part_that_begins_where_the_result_has_ended_fails(run, livelink_rows, tmp_path):
    livelink_rows.to_csv(tmp_path / "source.csv", index=False)
    _, _, ledger = run([clip("s_0", 0, 4 / 30), clip("s_1", 1.0, 2.0)], max_missing=0.5)
    row = ledger.loc["s_1"]
    assert row[["status", "rule"]].tolist() == ["failed", "shorter_than_clip"]
    assert row["detail"] == "source.csv ends after 0.17 s, the clip begins at 1 s"
    assert (ledger.loc[["s_0"], "status"] == "kept").all()


def test_a_part_of_a_take_without_a_frame_is_dropped(run, livelink_rows, tmp_path):
    livelink_rows.to_csv(tmp_path / "source.csv", index=False)
    _, _, ledger = run([clip("s_0", 0, 4 / 30), clip("s_1", 0.05, 0.051)], max_missing=0.5)
    assert ledger.loc["s_1", ["status", "rule"]].tolist() == ["dropped", "tracking_lost"]


def filmed(clip_id: str, n_frames: int, fps: int = 30) -> dict:
    media = {"media": f"{clip_id}.mp4", "fps_num": fps, "fps_den": 1, "n_frames": n_frames}
    return clip(clip_id, 0, n_frames / fps) | media


@pytest.mark.parametrize(("n_frames", "by"), [(4, 1), (6, -1)])
def test_a_result_of_another_length_than_the_video_says_by_how_much(
    run, livelink_rows, tmp_path, n_frames, by
):
    livelink_rows.to_csv(tmp_path / "a.csv", index=False)  # five frames
    motion, kept, ledger = run([filmed("a", n_frames)], max_missing=0.5)
    assert len(motion) == kept["n_frames"].item() == n_frames
    assert noted(ledger, "a", "frame_count")[["value", "unit"]].tolist() == [by, "frames"]


def test_a_result_much_longer_than_the_video_fails(run, livelink_rows, tmp_path):
    livelink_rows.to_csv(tmp_path / "a.csv", index=False)
    _, _, ledger = run([filmed("a", 2)])
    assert ledger.loc["a", ["rule", "value", "limit"]].tolist() == ["longer_than_clip", 5, 2]


TABLE = {"folder": ".", "fps": "30", "channels": {}, "angle_unit": "radians", "frame": None}
TABLE |= {"first_frame": 0, "valid": None, "confidence": None, "loss": None}


def test_rows_that_are_counted_have_to_fill_the_video_and_frames_that_are_numbered_need_not(
    run, tmp_path
):
    rows = pd.DataFrame(np.random.default_rng(0).uniform(0.1, 0.4, (60, 52)), columns=EXPRESSIONS)
    rows.assign(frame=range(60)).to_csv(tmp_path / "a.csv", index=False)
    for n_frames, status in ((62, "kept"), (63, "failed")):
        _, _, ledger = run([filmed("a", n_frames)], format="table", options=TABLE)
        assert set(ledger["status"]) == {status}
    assert ledger.loc["a", ["rule", "value", "limit"]].tolist() == ["shorter_than_clip", 60, 63]
    motion, _, ledger = run([filmed("a", 70)], format="table", options=TABLE | {"frame": "frame"})
    assert motion["valid"].sum() == 60 and len(motion) == 70
    assert "ends after 60 of 70 frames" in noted(ledger, "a", "masked")["detail"]
    row = noted(ledger, "a", "frame_count")
    assert row["value"] == -10 and np.isnan(row["limit"])  # no limit that it would be beyond


def test_a_result_at_another_rate_than_the_video_fails(run, livelink_rows, tmp_path):
    livelink_rows.to_csv(tmp_path / "a.csv", index=False)
    _, _, ledger = run([filmed("a", 5, fps=25)])
    row = ledger.loc["a"]
    assert row[["status", "rule", "value", "limit"]].tolist() == ["failed", "frame_rate", 30, 25]
    assert "fetch.fps" in row["detail"]


def test_bad_files_fail_and_the_rest_goes_on(run, livelink_rows, tmp_path):
    livelink_rows.to_csv(tmp_path / "good.csv", index=False)
    livelink_rows.to_csv(tmp_path / "headless.csv", index=False, header=False)
    livelink_rows.assign(JawOpen="text").to_csv(tmp_path / "text.csv", index=False)
    names = ["good", "headless", "text", "missing"]
    motion, _, ledger = run([clip(name, 0, 5 / 30, name) for name in names])
    assert motion["clip_id"].unique().tolist() == ["good"]
    assert ledger["status"].groupby("clip_id").first().to_dict() == {
        "good": "kept"
    } | dict.fromkeys(names[1:], "failed")
    assert ledger.loc["missing", "rule"] == "no_tracking_result"
    assert "line 2, column JawOpen" in ledger.loc["text", "detail"]


def test_an_empty_shard_gives_empty_tables_with_their_types(run):
    motion, kept, ledger = run([])
    assert len(motion) == len(kept) == len(ledger) == 0
    assert motion["jawOpen"].dtype == np.float32


def test_the_result_of_mirrored_pictures_is_put_right(run, livelink_rows, tmp_path):
    livelink_rows.to_csv(tmp_path / "a.csv", index=False)
    motion, _, _ = run([clip("a", 0, 5 / 30)])
    other, _, _ = run([clip("a", 0, 5 / 30)], mirrored=True)
    assert other["mouthSmileLeft"].tolist()[:3] == motion["mouthSmileRight"].tolist()[:3]
    assert other["head_yaw_left"].tolist()[:3] == (-motion["head_yaw_left"]).tolist()[:3]


def test_every_channel_has_a_row_that_tells_how_it_was_had(run, livelink_rows, tmp_path):
    livelink_rows.drop(columns=["TongueOut", "BlendShapeCount"]).to_csv(
        tmp_path / "a.csv", index=False
    )
    run([clip("a", 0, 5 / 30)])
    origins = tables.read(tables.ORIGINS, tmp_path / "origins.parquet").set_index("channel")
    assert origins["measured"].sum() == 56
    assert not origins.loc["tongueOut", "measured"]
    assert "BrowDownLeft" in origins.loc["browDownLeft", "origin"]


def test_a_frame_whose_tracking_loss_is_too_large_drops_the_clip(run, livelink_rows, tmp_path):
    livelink_rows.to_csv(tmp_path / "a.csv", index=False)
    (tmp_path / "a.loss.csv").write_text("frame,loss\n0,0.1\n1,0.7\n2,0.2\n4,0.1\n")
    motion, _, ledger = run([clip("a", 0, 5 / 30)], max_loss=0.8)
    assert motion["tracker_loss"].tolist()[:3] == [0.1, 0.7, 0.2]
    assert "tracking_loss" not in set(ledger["rule"])
    _, kept, ledger = run([clip("a", 0, 5 / 30)], max_loss=0.5)
    assert kept.empty
    row = ledger.loc["a"]
    assert row[["status", "rule", "value", "limit"]].tolist() == [
        "dropped",
        "tracking_loss",
        0.7,
        0.5,
    ]
    assert row[["first_frame", "last_frame"]].tolist() == [1, 1]


def test_a_loss_after_the_clip_has_ended_is_not_the_clip_s(run, tmp_path):
    looking(62, 1).to_csv(tmp_path / "a.csv", index=False)
    losses = [0.1] * 60 + [9, 9]
    pd.DataFrame({"frame": range(62), "loss": losses}).to_csv(tmp_path / "a.loss.csv", index=False)
    motion, _, _ = run([filmed("a", 60)], max_loss=0.5)
    assert len(motion) == 60
    _, _, ledger = run([filmed("a", 61)], max_loss=0.5)
    assert ledger.loc["a", ["status", "rule"]].tolist() == ["dropped", "tracking_loss"]


def test_landmarks_without_a_face_to_hold_them_to_say_what_the_loss_needs(run, tmp_path):
    shutil.copytree(GOLDEN / "metrical_tracker" / "turns_left", tmp_path / "a")
    (tmp_path / "a" / "kpt").mkdir()
    for number in range(1, 6):
        np.save(tmp_path / "a" / "kpt" / f"{number:05d}.npy", np.arange(136.0).reshape(68, 2))
    options = {"folder": ".", "fps": "30", "face": None}
    _, _, ledger = run([clip("a", 0, 5 / 30)], format="metrical_tracker", options=options)
    detail = noted(ledger, "a", "tracking_loss")["detail"]
    assert detail.startswith("not applied: ") and "ingest.metrical_tracker.face" in detail


def test_frames_that_are_lost_since_every_coefficient_is_0_are_told(run, tmp_path):
    rows = looking(60, 1)
    rows.loc[20:29, rows.columns[1:]] = 0.0
    rows.to_csv(tmp_path / "source.csv", index=False)
    _, _, ledger = run([clip("a", 0, 1), clip("b", 1, 2)], max_missing=0.5)
    detail = noted(ledger, "a", "masked")["detail"]
    assert detail == "10 of them since every coefficient is 0"
    assert "masked" not in set(ledger.loc[["b"], "rule"])


@pytest.mark.parametrize("sidecar", ["", "frame,loss\n0,0.1\n"])
def test_where_the_loss_has_no_limit_or_is_not_known_the_ledger_says_so(
    run, livelink_rows, tmp_path, sidecar
):
    livelink_rows.to_csv(tmp_path / "a.csv", index=False)
    if sidecar:
        (tmp_path / "a.loss.csv").write_text(sidecar)
    _, _, ledger = run([clip("a", 0, 5 / 30)])
    assert noted(ledger, "a", "tracking_loss")["detail"].startswith("not applied: ")


def looking(n_frames: int, way: float) -> pd.DataFrame:
    """A take whose eyes go from side to side; way -1 has left and right of the angles exchanged."""
    left = np.sin(np.arange(n_frames) / 5)
    ticks = np.arange(n_frames)
    times = [f"10:00:{t // 30:02d}:{2 * (t % 30):02d}.000" for t in ticks]
    values = {name[0].upper() + name[1:]: 0.1 for name in EXPRESSIONS}
    values |= {"EyeLookOutLeft": left.clip(0), "EyeLookInRight": left.clip(0)}
    values |= {"EyeLookInLeft": (-left).clip(0), "EyeLookOutRight": (-left).clip(0)}
    eyes = {f"{side}EyeYaw": -0.6 * way * left for side in ("Left", "Right")}
    eyes |= {f"{side}EyePitch": 0.01 * left for side in ("Left", "Right")}
    return pd.DataFrame({"Timecode": times, **values, **eyes})


def test_one_clip_with_sides_exchanged_fails_and_many_stop_the_run(run, tmp_path):
    names = ["a", "b", "c", "d"]
    for name in names:
        looking(60, -1 if name == "a" else 1).to_csv(tmp_path / f"{name}.csv", index=False)
    _, kept, ledger = run([clip(name, 0, 2, name) for name in names])
    assert ledger.loc["a", ["status", "rule"]].tolist() == ["failed", "sides_swapped"]
    assert kept["clip_id"].tolist() == names[1:]
    for name in names:
        looking(60, -1).to_csv(tmp_path / f"{name}.csv", index=False)
    with pytest.raises(MimelineError, match="4 of the 4 takes"):
        run([clip(name, 0, 2, name) for name in names])


def test_one_source_with_a_fault_does_not_stop_the_run_however_many_clips_it_has(run, tmp_path):
    looking(600, -1).to_csv(tmp_path / "source.csv", index=False)
    degrees = looking(600, 1)
    eyes = [column for column in degrees if column.endswith("Yaw")]
    degrees[eyes] = np.degrees(degrees[eyes])
    degrees.to_csv(tmp_path / "other.csv", index=False)
    for name in "abcd":
        looking(60, 1).to_csv(tmp_path / f"{name}.csv", index=False)
    clips = [clip(f"{s}_{n}", 2 * n, 2 * n + 2, s) for s in ("source", "other") for n in range(10)]
    _, kept, ledger = run([*clips, *(clip(name, 0, 2, name) for name in "abcd")])
    assert kept["clip_id"].tolist() == ["a", "b", "c", "d"]
    assert (ledger["status"] == "failed").sum() == 20


def openface_rows(n_frames: int) -> pd.DataFrame:
    """A head that turns to its left and back, with the landmarks of its face."""
    rows = pd.read_csv(GOLDEN / "openface" / "turns_left.csv")
    rows = pd.concat([rows, rows[::-1]] * n_frames, ignore_index=True)[:n_frames]
    rows.columns = rows.columns.str.strip()
    points = pd.DataFrame(100.0, rows.index, [f"{axis}_{n}" for axis in "xy" for n in range(68)])
    points["x_0"], points["x_16"] = 30.0, 170.0  # the jaw's ends, the subject's right one first
    points["x_30"] = 100 + 60 * rows["pose_Ry"].abs()  # the nose
    times = {"frame": range(1, n_frames + 1), "timestamp": np.arange(n_frames) / 30}
    return rows.assign(**times).join(points)


def test_of_mirrored_pictures_landmarks_bear_witness_and_are_left_out(run, tmp_path):
    options, path = {"folder": ".", "fps": "30"}, tmp_path / "a.csv"
    chosen = {"format": "openface", "options": options, "mirrored": True}
    rows = openface_rows(60)
    rows.to_csv(path, index=False)
    motion, _, _ = run([clip("a", 0, 2)], **chosen)
    assert motion["head_yaw_left"].min() < -0.2
    assert tables.reason(tmp_path / "landmarks.parquet") == "left out: the pictures were mirrored"
    rows.assign(pose_Ry=-rows["pose_Ry"]).to_csv(path, index=False)
    _, _, ledger = run([clip("a", 0, 2)], **chosen)
    assert ledger.loc["a", ["status", "rule"]].tolist() == ["failed", "sides_swapped"]


def test_takes_that_are_all_refused_for_what_one_key_mends_stop_the_run(run, tmp_path):
    names = ["a", "b", "c"]
    for name in names:
        degrees = looking(60, 1)
        eyes = [column for column in degrees if column.endswith("Yaw")]
        degrees[eyes] = np.degrees(degrees[eyes])
        degrees.to_csv(tmp_path / f"{name}.csv", index=False)
    with pytest.raises(MimelineError, match="3 of 3 takes.*angle_unit: degrees"):
        run([clip(name, 0, 2, name) for name in names])
    motion, _, _ = run(
        [clip(name, 0, 2, name) for name in names], options=OPTIONS | {"angle_unit": "degrees"}
    )
    assert motion["gaze_left"].max() == pytest.approx(0.6, abs=0.01)


def test_sides_and_units_that_nothing_tells_are_said_to_be_unchecked(run, tmp_path):
    looking(60, 1).to_csv(tmp_path / "moving.csv", index=False)
    looking(60, 1).assign(LeftEyeYaw=0.01, RightEyeYaw=0.01).to_csv(
        tmp_path / "still.csv", index=False
    )
    _, _, ledger = run([clip(name, 0, 2, name) for name in ("moving", "still")])
    for rule in ("sides_swapped", "angle_unit"):
        assert noted(ledger, "still", rule)["detail"].startswith("not applied: ")
    assert not {"sides_swapped", "angle_unit"} & set(ledger.loc[["moving"], "rule"])


def test_a_channel_without_a_number_is_not_called_measured(run, tmp_path):
    looking(60, 1).assign(JawOpen=np.nan).to_csv(tmp_path / "a.csv", index=False)
    run([clip("a", 0, 2, "a")], bad_values="mask", max_missing=1)
    origins = tables.read(tables.ORIGINS, tmp_path / "origins.parquet").set_index("channel")
    assert not origins.loc["jawOpen", "measured"]
