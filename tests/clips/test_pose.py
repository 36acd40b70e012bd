import numpy as np
import pandas as pd
import pytest

from mimeline.clips.pose import mask_turned, read_sixdrepnet
from mimeline.errors import BadFile, MissingColumn


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
