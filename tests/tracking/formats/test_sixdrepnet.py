import numpy as np
import pytest

from mimeline.errors import BadFile, MissingColumn
from mimeline.tracking.formats.sixdrepnet import read_sixdrepnet


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
