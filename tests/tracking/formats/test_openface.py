import itertools
import logging
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mimeline.errors import BadFile, MimelineError, MissingColumn
from mimeline.face.rotations import turned
from mimeline.tracking.formats import openface
from mimeline.vocabulary import CHANNELS

GOLDEN = Path(__file__).parents[1] / "golden" / "openface"
HEAD = ["head_yaw_left", "head_pitch_up", "head_tilt_left"]


def golden(name: str) -> pd.DataFrame:
    return pd.read_csv(GOLDEN / f"{name}.csv", skipinitialspace=True)


def read(rows, tmp_path, bad_values="fail"):
    path = tmp_path / "clip.csv"
    rows.to_csv(path, index=False)
    return openface.read(path, bad_values, "30")


def with_cell(rows, column, row, cell):
    rows = rows.astype({column: object})
    rows.loc[row, column] = cell
    return rows


def test_builds_that_write_spaces_and_no_face_id_read_the_same(tmp_path):
    rows = golden("turns_left")
    spaced, plain = tmp_path / "spaced.csv", tmp_path / "plain.csv"
    rows.to_csv(plain, index=False)
    lines = rows.drop(columns="face_id").to_csv(index=False).replace(",", ", ")
    spaced.write_text("\ufeff" + lines, encoding="utf-8")
    one, other = (openface.read(path, "fail", "30").motion for path in (plain, spaced))
    pd.testing.assert_frame_equal(one, other)


def test_groups_of_columns_that_are_absent_are_not_measured_and_say_so(tmp_path):
    rows = golden("turns_left")
    pose = [name for name in rows if name.startswith("pose_")]
    take = read(rows.drop(columns=pose), tmp_path)
    assert take.motion[[*HEAD, "gaze_left"]].isna().all(axis=None)
    assert not take.origins["head_yaw_left"].measured
    assert "without a pose" in take.origins["gaze_left"].text
    assert take.motion["mouthSmileLeft"].notna().all()
    take = read(rows[[n for n in rows if not n.startswith(("AU", "gaze"))]], tmp_path)
    assert "AU12 is not in the table" in take.origins["mouthSmileLeft"].text
    assert take.motion["head_yaw_left"].notna().all()
    assert take.coefficients == {}


@pytest.mark.parametrize("missing", ["-nan(ind)", "nan", " -nan "])
def test_what_openface_writes_for_missing_is_missing_and_no_bad_value(tmp_path, missing):
    motion = read(with_cell(golden("turns_left"), "AU12_r", 1, missing), tmp_path).motion
    assert motion["valid"].all()
    assert motion["mouthSmileLeft"].isna().tolist() == [False, True, False, False, False]


@pytest.mark.parametrize("column", ["AU12_r", "pose_Rx", "gaze_0_x"])
def test_an_empty_cell_of_a_face_that_was_found_is_named_or_masks_its_frame(tmp_path, column):
    rows = with_cell(golden("turns_left"), column, 1, "")
    with pytest.raises(BadFile, match=f"line 3, column {column}: found ''"):
        read(rows, tmp_path)
    valid = [True, False, True, True, True]
    assert read(rows, tmp_path, "mask").motion["valid"].tolist() == valid
    rows = with_cell(rows, "success", 1, 0)
    assert read(rows, tmp_path).motion["valid"].tolist() == valid
    rows[column] = ""  # never given
    assert read(rows, tmp_path).motion["jawOpen"].notna().tolist() == valid


def test_a_file_that_is_cut_off_is_refused_or_loses_its_last_frame(tmp_path):
    path = tmp_path / "clip.csv"
    rows = golden("turns_left")
    *lines, last = rows.to_csv(index=False).splitlines()
    cells = last.split(",")[: rows.columns.get_loc("AU12_r")]
    path.write_text("\n".join([*lines, ",".join(cells)]))
    counts = f"line 6: found {len(cells)} cells, expected {rows.shape[1]}"
    with pytest.raises(BadFile, match=counts):
        openface.read(path, "fail", "30")
    assert openface.read(path, "mask", "30").motion["valid"].tolist() == [True] * 4 + [False]


def test_text_in_a_number_is_named_or_masks_its_frame(tmp_path):
    rows = with_cell(golden("turns_left"), "AU12_r", 1, "strong")
    with pytest.raises(BadFile, match="line 3, column AU12_r.*'strong'"):
        read(rows, tmp_path)
    assert read(rows, tmp_path, "mask").motion["valid"].tolist() == [True, False, True, True, True]


def test_a_row_without_success_is_a_lost_frame_whatever_it_holds(tmp_path):
    rows = with_cell(golden("turns_left"), "AU12_r", 2, "garbage")
    rows.loc[2, "success"] = 0
    take = read(rows, tmp_path)
    assert take.motion["valid"].tolist() == [True, True, False, True, True]
    assert take.motion.loc[2, list(CHANNELS)].isna().all()
    assert take.coefficients["action_units"].loc[2].isna().all()


def test_the_face_that_is_surest_over_all_frames_is_taken_in_each(tmp_path, caplog):
    rows = golden("turns_left").assign(confidence=0.8)
    other = rows.assign(face_id=1, AU12_r=5.0, pose_Ry=0.5, confidence=[0.9, 0.3, 0.9, 0.3, 0.9])
    lost = rows.assign(face_id=2, AU12_r=4.0, confidence=1.0, success=0)
    alone = read(rows, tmp_path).motion
    assert "faces" not in caplog.text
    with caplog.at_level(logging.WARNING):
        among = read(pd.concat([other, lost, rows]), tmp_path).motion
    pd.testing.assert_frame_equal(among, alone)
    assert "2 other faces are left out" in caplog.text


def test_a_frame_that_holds_another_face_alone_is_lost(tmp_path):
    rows = golden("turns_left")
    rows.loc[[1, 4], "face_id"] = 7
    motion = read(rows, tmp_path).motion
    assert motion["valid"].tolist() == [True, False, True, True, False]
    assert motion["confidence"].notna().tolist() == motion["valid"].tolist()


def test_intensities_of_another_scale_are_refused(tmp_path):
    rows = golden("turns_left").assign(AU01_r=[0, 20, 40, 60, 100])
    with pytest.raises(BadFile, match="line 3, column AU01_r: found 20, expected an intensity"):
        read(rows, tmp_path)


@pytest.mark.parametrize("dropped", [[], ["face_id"]])
def test_a_frame_that_comes_twice_is_refused(tmp_path, dropped):
    rows = golden("turns_left").drop(columns=dropped)
    with pytest.raises(BadFile, match="column frame.*twice"):
        read(pd.concat([rows, rows.tail(1)]), tmp_path)


def test_intensities_beyond_their_range_are_clipped_and_counted(tmp_path, caplog):
    rows = golden("turns_left")
    rows.loc[0, "AU12_r"], rows.loc[1, "AU45_r"] = -0.3, 5.7
    with caplog.at_level(logging.WARNING):
        take = read(rows, tmp_path)
    assert "2 action-unit intensities" in caplog.text
    assert take.motion["mouthSmileLeft"].iloc[0] == 0
    assert take.motion["eyeBlinkLeft"].iloc[1] == 1
    assert take.coefficients["action_units"]["AU45_r"].iloc[1] == 5


def test_timestamps_are_not_looked_at(tmp_path):
    rows = golden("turns_left")
    wild = rows.assign(timestamp=["?", "-1", "", "0", "1e9"])
    pd.testing.assert_frame_equal(read(rows, tmp_path).motion, read(wild, tmp_path).motion)


def test_frames_count_from_1_and_those_left_out_are_gaps(tmp_path):
    take = read(golden("turns_left").assign(frame=[2, 3, 4, 6, 7]), tmp_path)
    assert take.first_frame == 2
    assert take.motion["valid"].tolist() == [False, True, True, True, False, True, True]


def test_a_table_with_a_frame_0_counts_from_there_and_says_so(tmp_path):
    take = read(golden("turns_left").assign(frame=range(5)), tmp_path)
    assert take.first_frame == 0
    assert take.motion["valid"].tolist() == [True] * 5


@pytest.mark.parametrize("frame", [1.5, -1, 1e30, 2_000_000])
def test_frames_that_are_no_count_are_refused(tmp_path, frame):
    with pytest.raises(BadFile, match="frame"):
        read(golden("turns_left").assign(frame=[1, 2, 3, 4, frame]), tmp_path)


def test_the_pose_is_the_matrix_rx_ry_rz_in_the_cameras_axes(tmp_path):
    angles = np.random.default_rng(0).uniform(-0.9, 0.9, (5, 3))
    R = turned(*angles.T).astype(float)  # subject's frame: Y and Z of the camera the other way
    flip = np.diag([1, -1, -1])
    R = flip @ R @ flip
    rows = golden("turns_left").assign(
        pose_Rx=np.arctan2(-R[:, 1, 2], R[:, 2, 2]),
        pose_Ry=np.arcsin(R[:, 0, 2]),
        pose_Rz=np.arctan2(-R[:, 0, 1], R[:, 0, 0]),
    )
    np.testing.assert_allclose(read(rows, tmp_path).motion[HEAD], angles, atol=1e-5)


def test_eyes_that_stay_on_the_camera_turn_against_the_head(tmp_path):
    rows = golden("turns_left")
    eyes = [name for name in rows if name.startswith("gaze_")]
    rows[eyes] = rows.loc[0, eyes].to_numpy(float)
    motion = read(rows, tmp_path).motion
    np.testing.assert_allclose(motion["gaze_left"], -motion["head_yaw_left"], atol=1e-4)


@pytest.mark.parametrize("move", ["looks_left", "looks_up", "turns_right"])
def test_gaze_angles_alone_say_what_the_vectors_say(tmp_path, move):
    rows = golden(move)
    vectors = [f"gaze_{eye}_{axis}" for eye in (0, 1) for axis in "xyz"]
    one, other = (read(r, tmp_path).motion for r in (rows, rows.drop(columns=vectors)))
    np.testing.assert_allclose(
        one[["gaze_left", "gaze_up"]], other[["gaze_left", "gaze_up"]], atol=1e-5
    )


def test_a_pose_in_degrees_is_refused(tmp_path):
    with pytest.raises(BadFile, match="pose_Ry.*within half a turn"):
        read(golden("turns_left").assign(pose_Ry=20.0), tmp_path)


def test_landmarks_lie_in_a_table_of_their_own_and_give_no_loss(tmp_path):
    rng = np.random.default_rng(2)
    points = {f"{axis}_{n}": rng.uniform(1, 500, 5) for axis in "xyXYZ" for n in range(68)}
    rows = pd.concat([golden("turns_left"), pd.DataFrame(points)], axis=1)
    rows.loc[1, "success"] = 0
    take = read(rows, tmp_path)
    landmarks = take.coefficients["landmarks"]
    assert landmarks["y_07"].iloc[0] == pytest.approx(points["y_7"][0])
    assert landmarks.iloc[1].isna().all()
    assert take.loss == "" and take.motion["tracker_loss"].isna().all()


@pytest.mark.parametrize("column", ["frame", "confidence", "success"])
def test_a_column_that_no_build_leaves_out_is_missed(tmp_path, column):
    with pytest.raises(MissingColumn, match=column):
        read(golden("turns_left").drop(columns=column), tmp_path)


def test_a_header_alone_and_a_table_of_lost_frames(tmp_path):
    with pytest.raises(BadFile, match="at least a frame"):
        read(golden("turns_left").head(0), tmp_path)
    assert not read(golden("turns_left").assign(success=0), tmp_path).motion["valid"].any()


def test_only_its_own_tables_are_held_for_it(tmp_path):
    assert openface.holds(GOLDEN / "turns_left.csv")
    (tmp_path / "other.csv").write_text("frame,FaceScore,jawOpen\n0,1,0\n")
    assert not openface.holds(tmp_path / "other.csv")
    assert not openface.holds(tmp_path / "none.csv")


CELLS = st.sampled_from(["", "-nan(ind)", "x", "1e400", "-1", "inf", '"', "99999999999999999999"])


@settings(max_examples=20, deadline=None)
@given(column=st.integers(0, 55), row=st.integers(0, 4), cell=CELLS)
def test_a_broken_cell_gives_a_take_or_our_error(tmp_path_factory, column, row, cell):
    lines = [line.split(", ") for line in (GOLDEN / "turns_left.csv").read_text().splitlines()]
    lines[row + 1][column % len(lines[0])] = cell
    path = tmp_path_factory.getbasetemp() / "openface_cell.csv"
    path.write_text("\n".join(",".join(line) for line in lines))
    for bad_values in ("fail", "mask"):
        try:
            motion = openface.read(path, bad_values, "30").motion
        except MimelineError:
            continue
        assert motion.loc[~motion["valid"], list(CHANNELS)].isna().all(axis=None)


@pytest.fixture(scope="module")
def real(real_data):
    path = real_data / "openface" / "OpenFace_Test.csv"
    return pd.read_csv(path, skipinitialspace=True), openface.read(path, "fail", "30")


def in_space(rows: pd.DataFrame) -> np.ndarray:
    """Landmarks (n, 68, 3), mm, in the camera's axes."""
    return np.stack([rows[[f"{a}_{n}" for n in range(68)]].to_numpy() for a in "XYZ"], axis=-1)


def about(axis: int, angle: np.ndarray) -> np.ndarray:
    turn = np.zeros((len(angle), 3, 3))
    after, last = (axis + 1) % 3, (axis + 2) % 3
    turn[:, axis, axis] = 1
    turn[:, after, after] = turn[:, last, last] = np.cos(angle)
    turn[:, last, after], turn[:, after, last] = np.sin(angle), -np.sin(angle)
    return turn


def test_a_real_pose_turns_its_landmarks_back_onto_one_another(real):
    rows, _ = real
    pose = rows[["pose_Rx", "pose_Ry", "pose_Rz"]].to_numpy().T
    rigid = in_space(rows)[:, 27:48]  # nose and eyes: (n, 21, 3)
    rigid = rigid - rigid.mean(axis=1, keepdims=True)
    residue = {}
    for signs in itertools.product((1, -1), repeat=3):
        x, y, z = (about(axis, signs[axis] * pose[axis]) for axis in range(3))
        back = rigid @ (x @ y @ z)  # row vectors: R transposed
        residue[signs] = np.sqrt(((back - back.mean(axis=0)) ** 2).sum(-1).mean())
    assert min(residue, key=residue.get) == (1, 1, 1)


def test_a_real_head_is_held_as_its_landmarks_lie(real):
    rows, take = real
    points = in_space(rows)
    eyes = points[:, 45] - points[:, 36]  # from the subject's right to the left outer corner
    chin = points[:, 8] - points[:, 27]
    motion = take.motion
    receding = np.arctan2(eyes[:, 2], eyes[:, 0])  # the left eye recedes in a turn to the left
    np.testing.assert_allclose(motion["head_yaw_left"], receding, atol=0.03)
    sinking = np.arctan2(eyes[:, 1], eyes[:, 0])  # it sinks where the head tilts to the left
    np.testing.assert_allclose(motion["head_tilt_left"], sinking, atol=0.03)
    forward = np.arctan2(-chin[:, 2], chin[:, 1])  # the chin comes forward in a lifted face
    assert np.corrcoef(motion["head_pitch_up"], forward)[0, 1] > 0.9
    assert motion["head_pitch_up"].max() < -0.2 and forward.max() < 0  # this face looks down


def test_real_eyes_meet_and_look_up_to_the_camera_from_a_lowered_head(real):
    rows, take = real
    assert (rows["gaze_0_x"] > 0).all() and (rows["gaze_1_x"] < 0).all()  # eye 0: leftmost
    assert take.motion["gaze_left"].abs().max() < 0.1
    assert take.motion["gaze_up"].between(0.2, 0.35).all()
    assert (take.motion["head_pitch_up"] + take.motion["gaze_up"]).abs().max() < 0.15
    assert take.first_frame == 1 and len(take.motion) == 100


def test_real_landmarks_in_space_are_those_of_the_picture_so_that_they_tell_no_loss(real):
    """One camera, found from all of them, sees them where the picture has them: to 0.001 pixels."""
    rows, take = real
    for seen, there in ("xX", "yY"):
        flat = [
            rows[[f"{axis}_{n}" for n in range(68)]].to_numpy().ravel()
            for axis in (seen, there, "Z")
        ]
        ray = flat[1] / flat[2]
        terms = np.stack([ray, np.ones_like(ray)], axis=1)
        left = flat[0] - terms @ np.linalg.lstsq(terms, flat[0], rcond=None)[0]
        assert np.abs(left).max() < 1e-3
    assert take.loss == ""


def test_a_table_has_no_loss_and_says_why(tmp_path):
    take = read(golden("turns_left"), tmp_path)
    assert take.loss == ""
    assert "landmarks" in take.no_loss
    assert take.motion["tracker_loss"].isna().all()
