import numpy as np
import pytest

from mimeline.errors import BadFile, MissingColumn
from mimeline.tracking.formats.sixdrepnet import read_head, read_sixdrepnet


def test_angles_of_6drepnet_take_the_subjects_left_and_up_as_positive(tmp_path):
    path = tmp_path / "pose.csv"
    path.write_text("clip_id,frame,pitch,yaw,roll\n007,0,10,20,30\n")
    row = read_sixdrepnet(path).iloc[0]
    assert row["clip_id"] == "007"
    assert np.degrees(row["head_yaw_left"]) == pytest.approx(-20)
    assert np.degrees(row["head_pitch_up"]) == pytest.approx(10)
    assert np.degrees(row["head_tilt_left"]) == pytest.approx(30)


@pytest.mark.parametrize(
    ("text", "error", "message"),
    [
        ("clip_id,frame,pitch\na,0,1\n", MissingColumn, "yaw, roll"),
        ("clip_id,frame,pitch,yaw,roll\na,0,1,x,2\n", BadFile, "line 2, column yaw"),
        ("clip_id,frame,pitch,yaw,roll\na,inf,1,2,2\n", BadFile, "line 2, column frame"),
        (
            "clip_id,frame,pitch,yaw,roll\na,0,1,2,2\n\na,1.5,1,2,2\n",
            BadFile,
            "line 4, column frame",
        ),
        (
            "clip_id,frame,pitch,yaw,roll\na,0,1,2,2\nb,0,1,2,2\n\na,0,1,60,2\n",
            BadFile,
            "line 5, column frame: found frame 0 of a clip again",
        ),
        ("clip_id,frame,pitch,yaw,roll\na,0,1,270,2\n", BadFile, "column yaw.*half a turn"),
        ("", BadFile, "pose.csv"),
    ],
)
def test_a_table_that_cannot_be_read_names_the_place(tmp_path, text, error, message):
    path = tmp_path / "pose.csv"
    path.write_text(text)
    with pytest.raises(error, match=message):
        read_sixdrepnet(path)


def test_a_missing_table_names_the_key():
    with pytest.raises(BadFile, match="pose.sixdrepnet.file"):
        read_sixdrepnet("nowhere.csv")


def test_one_table_may_hold_more_clips_than_are_asked_for(tmp_path, monkeypatch):
    monkeypatch.setattr("mimeline.tracking.formats.clip_tables.ROWS", 2)  # several pieces
    path = tmp_path / "pose.csv"
    rows = [f"{clip},{frame},0,{frame},nan" for clip in ("a", "007", "b") for frame in range(3)]
    path.write_text("\n".join(["\ufeffClip_ID, Frame,Pitch,YAW,roll", *rows, "c,0,0,x,0"]))
    poses = read_sixdrepnet(path, {"007", "b"})
    assert poses["clip_id"].tolist() == ["007"] * 3 + ["b"] * 3
    assert poses["frame"].tolist() == [0, 1, 2] * 2
    assert np.allclose(np.degrees(poses["head_yaw_left"]), [0, -1, -2] * 2)
    assert poses["head_tilt_left"].isna().all()
    assert read_sixdrepnet(path, {"nobody"}).empty
    with pytest.raises(BadFile, match="line 11, column yaw"):
        read_sixdrepnet(path)


def test_a_table_of_one_clip_needs_neither_names_nor_frames(tmp_path):
    path = tmp_path / "clip.csv"
    path.write_text("pitch,yaw,roll\n1,2,3\n,NaN,4\n")
    poses = read_head(path)
    assert poses["frame"].tolist() == [0, 1]
    assert np.degrees(poses["head_yaw_left"][0]) == pytest.approx(-2)
    assert poses.loc[1, ["head_yaw_left", "head_pitch_up"]].isna().all()
