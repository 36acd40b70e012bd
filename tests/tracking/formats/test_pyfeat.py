import logging
from fractions import Fraction

import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.errors import BadFile, MissingColumn
from mimeline.tracking.formats import pyfeat
from mimeline.vocabulary import CHANNELS


def read(rows, tmp_path, stride=2, bad_values="fail"):
    path = tmp_path / "clip.csv"
    rows.to_csv(path, index=False)
    return pyfeat.read(path, fps="25", stride=stride, bad_values=bad_values)


def test_every_second_frame_gives_a_clock_of_half_the_rate(pyfeat_rows, tmp_path):
    take = read(pyfeat_rows, tmp_path)
    assert take.fps == Fraction(25, 2)
    assert take.motion["frame"].tolist() == [0, 1, 2, 3, 4]


def test_a_face_that_comes_late_leaves_the_frames_before_it_not_valid(pyfeat_rows, tmp_path):
    motion = read(pyfeat_rows, tmp_path).motion  # found from frame 4 of the video on
    assert motion["valid"].tolist() == [False, False, True, True, True]
    assert motion["jawOpen"].iloc[2] == pytest.approx(pyfeat_rows["jawOpen"].iloc[0])


@pytest.mark.parametrize("frames", [[0, 2, 3], [0, 0.5, 1], [-2, 0, 2]])
def test_a_frame_that_is_no_multiple_of_the_stride_is_refused(pyfeat_rows, tmp_path, frames):
    with pytest.raises(BadFile, match="column frame.*ingest.pyfeat.stride"):
        read(pyfeat_rows.assign(frame=frames), tmp_path)


def test_a_table_of_which_no_row_tells_its_frame_is_refused(pyfeat_rows, tmp_path):
    with pytest.raises(BadFile, match="at least a frame"):
        read(pyfeat_rows.assign(frame="?"), tmp_path, bad_values="mask")


def test_an_absurd_frame_number_is_refused_before_memory_is_taken(pyfeat_rows, tmp_path):
    with pytest.raises(BadFile, match="less than 1000000 frames"):
        read(pyfeat_rows.assign(frame=[0, 2, 2_000_000_000]), tmp_path)
    with pytest.raises(BadFile, match="less than 1000000 frames"):
        read(pyfeat_rows.assign(frame=[0, 2, 1e30]), tmp_path)


def test_what_the_format_lacks_is_not_measured(pyfeat_rows, tmp_path):
    motion = read(pyfeat_rows, tmp_path).motion
    assert motion["tongueOut"].isna().all()
    assert motion.loc[motion["valid"], "jawOpen"].notna().all()


def test_angles_take_the_subjects_left_and_up_as_positive(pyfeat_rows, tmp_path):
    first = read(pyfeat_rows, tmp_path).motion.iloc[2]
    assert first["head_yaw_left"] == pytest.approx(-0.3)
    assert first["head_pitch_up"] == pytest.approx(-0.1)
    assert first["head_tilt_left"] == pytest.approx(-0.2)
    assert first["gaze_left"] == pytest.approx(0.5)
    assert first["gaze_up"] == pytest.approx(0.4)


def at(rows, x, frames, scores):
    """The rows with a face of 100 pixels at x (a number, or one per row)."""
    box = {"FaceRectX": x, "FaceRectY": 50.0, "FaceRectWidth": 100.0, "FaceRectHeight": 100.0}
    return rows.assign(**box, frame=frames, FaceScore=scores)


def test_one_face_is_followed_from_its_surest_frame_though_others_are_surer(
    pyfeat_rows, tmp_path, caplog
):
    own = at(pyfeat_rows, [100.0, 130.0, 160.0], [0, 2, 4], [0.7, 0.99, 0.6])
    other = at(pyfeat_rows.assign(jawOpen=0.9), [400.0, 390.0, 380.0], [0, 2, 4], [0.9, 0.98, 0.95])
    alone = read(own, tmp_path).motion
    with caplog.at_level(logging.WARNING):
        among = read(pd.concat([other, own]), tmp_path).motion
    pd.testing.assert_frame_equal(among, alone)
    assert "3 rows of other faces are left out" in caplog.text


def test_a_frame_in_which_only_another_face_is_left_is_lost(pyfeat_rows, tmp_path):
    own = at(pyfeat_rows, [100.0, 110.0, 120.0], [0, 2, 6], [0.99, 0.7, 0.7])
    other = at(pyfeat_rows, [400.0, 390.0, 380.0], [2, 4, 6], [0.9, 0.9, 0.9])
    motion = read(pd.concat([own, other]), tmp_path).motion
    assert motion["valid"].tolist() == [True, True, False, True]
    np.testing.assert_allclose(motion["confidence"], [0.99, 0.7, np.nan, 0.7])


def test_a_row_without_a_rectangle_is_no_face_however_sure(pyfeat_rows, tmp_path):
    own = at(pyfeat_rows, [100.0, 110.0, 120.0], [0, 2, 4], [0.7, 0.7, 0.7])
    other = at(pyfeat_rows.assign(jawOpen=0.9), np.nan, [0, 2, 4], [0.9, 0.9, 0.9])
    motion = read(pd.concat([other, own]), tmp_path).motion
    pd.testing.assert_frame_equal(motion, read(own, tmp_path).motion)


def test_several_faces_without_their_rectangles_are_refused(pyfeat_rows, tmp_path):
    with pytest.raises(BadFile, match="FaceRectX.*several rows of a frame"):
        read(pyfeat_rows.assign(frame=[4, 4, 6]), tmp_path)


def test_a_frame_without_a_single_number_is_lost_though_its_face_was_found(pyfeat_rows, tmp_path):
    numbers = pyfeat_rows.columns.drop(["frame", "input", "FaceScore"])
    pyfeat_rows.loc[1, numbers] = np.nan  # written as empty cells
    assert read(pyfeat_rows, tmp_path).motion["valid"].tolist()[2:] == [True, False, True]


@pytest.mark.parametrize("column", ["jawOpen", "Yaw", "y_8"])
def test_an_empty_cell_of_a_face_that_was_found_is_named_or_masks_its_frame(
    pyfeat_rows, tmp_path, column
):
    rows = with_landmarks(pyfeat_rows)
    rows.loc[1, column] = np.nan
    with pytest.raises(BadFile, match=f"line 3, column {column}: found ''"):
        read(rows, tmp_path)
    valid = [True, False, True]
    assert read(rows, tmp_path, bad_values="mask").motion["valid"].tolist()[2:] == valid
    assert (
        read(rows.assign(**{column: np.nan}), tmp_path).motion["valid"].tolist()[2:] == [True] * 3
    )


def test_a_file_that_is_cut_off_is_refused_or_loses_its_last_frame(pyfeat_rows, tmp_path):
    path = tmp_path / "clip.csv"
    first = ["frame", "FaceScore"]
    rows = pyfeat_rows[[*first, *pyfeat_rows.columns.drop(first)]]
    *lines, last = rows.to_csv(index=False).splitlines()
    path.write_text("\n".join([*lines, ",".join(last.split(",")[:9])]))
    with pytest.raises(BadFile, match=f"line 4: found 9 cells, expected {rows.shape[1]}"):
        pyfeat.read(path, fps="25", stride=2, bad_values="fail")
    motion = pyfeat.read(path, fps="25", stride=2, bad_values="mask").motion
    assert motion["valid"].tolist()[2:] == [True, True, False]


def test_angles_in_degrees_are_refused_with_the_format_that_reads_them(pyfeat_rows, tmp_path):
    with pytest.raises(BadFile, match="column Yaw.*ingest.format: table.*angle_unit: degrees"):
        read(pyfeat_rows.assign(Yaw=20.0), tmp_path)


def test_a_frame_without_a_face_is_masked(pyfeat_rows, tmp_path):
    blank = pyfeat_rows.columns.drop(["frame", "input"])
    pyfeat_rows.loc[1, blank] = np.nan  # written as empty cells
    take = read(pyfeat_rows, tmp_path)
    assert take.motion["valid"].tolist()[2:] == [True, False, True]


def test_a_frame_that_was_left_out_is_masked(pyfeat_rows, tmp_path):
    pyfeat_rows["frame"] = [0, 2, 6]
    assert read(pyfeat_rows, tmp_path).motion["valid"].tolist() == [True, True, False, True]


def test_text_in_a_number_is_named_by_line_and_column(pyfeat_rows, tmp_path):
    pyfeat_rows["jawOpen"] = pyfeat_rows["jawOpen"].astype(object)
    pyfeat_rows.loc[1, "jawOpen"] = "wide"
    pyfeat_rows["FaceScore"] = [
        0.1,
        0.5,
        0.9,
    ]  # not the order of the file
    with pytest.raises(BadFile, match="line 3, column jawOpen.*'wide'"):
        read(pyfeat_rows, tmp_path)


def test_a_mirrored_picture_swaps_sides_and_negates_yaw_tilt_and_gaze(pyfeat_rows, tmp_path):
    def other(name):
        ends = {"Left": "Right", "Right": "Left"}
        end = next((e for e in ends if name.endswith(e)), None)
        return name.removesuffix(end) + ends[end] if end else name

    mirrored = pyfeat_rows.rename(columns=other)
    for angle in ("Yaw", "Roll", "gaze_yaw"):
        mirrored[angle] *= -1
    plain, turned = (read(rows, tmp_path).motion for rows in (pyfeat_rows, mirrored))
    for channel in CHANNELS.values():
        expected = channel.mirror_sign * plain[channel.mirror]
        np.testing.assert_allclose(turned[channel.name], expected, rtol=1e-6)


def test_a_missing_frame_column_is_refused(pyfeat_rows, tmp_path):
    with pytest.raises(MissingColumn, match="frame"):
        read(pyfeat_rows.drop(columns="frame"), tmp_path)


@pytest.mark.parametrize("lost", [{"FaceScore": 0.0}, {"FaceRectX": np.nan}])
def test_a_row_without_a_face_is_masked_whatever_else_it_holds(pyfeat_rows, tmp_path, lost):
    rows = pyfeat_rows.assign(FaceRectX=80.0)
    for column, value in lost.items():
        rows.loc[1, column] = value
    motion = read(rows, tmp_path).motion
    assert motion["valid"].tolist()[2:] == [True, False, True]
    assert motion.loc[3, list(CHANNELS)].isna().all()


def with_landmarks(rows):
    """x_0 at 100, and each of the others one further."""
    names = [f"{axis}_{point}" for axis in "xy" for point in range(68)]
    points = np.broadcast_to(100.0 + np.arange(136), (len(rows), 136))
    return pd.concat([rows, pd.DataFrame(points, columns=names)], axis=1)


def test_landmarks_come_beside_the_motion(pyfeat_rows, tmp_path):
    rows = with_landmarks(pyfeat_rows)
    rows.loc[1, "FaceScore"] = 0.0
    take = read(rows, tmp_path)
    landmarks = take.coefficients["landmarks"]
    assert landmarks.columns.tolist() == tables.COEFFICIENTS["landmarks"].schema.names[2:]
    assert len(landmarks) == len(take.motion)
    assert landmarks.notna().all(axis=1).tolist() == take.motion["valid"].tolist()
    assert landmarks.loc[2, ["x_00", "x_67", "y_00"]].tolist() == [100, 167, 168]
    assert read(pyfeat_rows, tmp_path).coefficients == {}


def test_a_wrong_cell_of_the_landmarks_is_named_too(pyfeat_rows, tmp_path):
    rows = with_landmarks(pyfeat_rows).astype({"y_8": object})
    rows.loc[2, "y_8"] = "low"
    with pytest.raises(BadFile, match="line 4, column y_8: found 'low'"):
        read(rows, tmp_path)


def test_every_channel_tells_how_it_was_had(pyfeat_rows, tmp_path):
    take = read(pyfeat_rows.drop(columns="gaze_yaw").assign(Roll=0.0), tmp_path)
    assert take.first_frame == 4
    assert list(take.origins) == list(CHANNELS)
    assert take.origins["jawOpen"].text == "column jawOpen"
    assert take.origins["head_yaw_left"].text == "column -Yaw"
    unmeasured = {name for name, origin in take.origins.items() if not origin.measured}
    assert unmeasured == {"tongueOut", "gaze_left", "head_tilt_left"}


def test_a_table_without_blend_shapes_is_refused(pyfeat_rows, tmp_path):
    rows = pyfeat_rows[["FaceScore", "Pitch", "Roll", "Yaw", "frame"]]
    with pytest.raises(MissingColumn, match="blend shapes"):
        read(rows, tmp_path)
    assert not pyfeat.holds(tmp_path / "clip.csv")
    pyfeat_rows.to_csv(tmp_path / "clip.csv", index=False)
    assert pyfeat.holds(tmp_path / "clip.csv")


def test_a_faulty_coefficient_is_found_where_it_stands(pyfeat_rows, tmp_path):
    pyfeat_rows["frame"] = [8, 4, 6]  # read in another order
    pyfeat_rows.loc[1, "jawOpen"] = 50.0
    with pytest.raises(BadFile, match="line 3, column jawOpen: found 50"):
        read(pyfeat_rows, tmp_path)


def test_real_landmarks_are_where_the_mesh_is(real_data):
    path = real_data / "pyfeat" / "001.csv"
    landmarks = pyfeat.read(path, fps="25", stride=2, bad_values="fail").coefficients["landmarks"]
    mesh = pd.read_csv(path)
    # The tip of the nose and the outer corners of the subject's right and left eye, in both.
    for point, corner in ((30, 4), (36, 33), (45, 263)):
        for axis in "xy":
            told = landmarks[f"{axis}_{point:02d}"].to_numpy()
            np.testing.assert_allclose(told, mesh[f"mesh_{axis}_{corner}"], atol=0.01)
    assert (landmarks["x_36"] < landmarks["x_45"]).all()  # the subject's right is at the left


def test_real_tables_read_and_turn_as_their_mesh_does(real_data):
    motions, meshes = [], []
    for path in sorted((real_data / "pyfeat").glob("0*.csv")):
        take = pyfeat.read(path, fps="25", stride=2, bad_values="fail")
        assert take.fps == Fraction(25, 2)
        motions.append(take.motion)
        meshes.append(pd.read_csv(path))
    motion, mesh = pd.concat(motions), pd.concat(meshes)
    # The outer corner of the left eye (263) recedes where the head turns to the subject's left.
    turn = mesh["mesh_z_263"] - mesh["mesh_z_33"]
    assert np.corrcoef(motion["head_yaw_left"], turn)[0, 1] > 0.9
    # The chin (152) comes forward against the forehead (10) where the head lifts.
    lift = mesh["mesh_z_10"] - mesh["mesh_z_152"]
    assert np.corrcoef(motion["head_pitch_up"], lift)[0, 1] > 0.9
    # The left eye sinks in the picture where the head tilts to the subject's left shoulder.
    tilt = mesh["mesh_y_263"] - mesh["mesh_y_33"]
    assert np.corrcoef(motion["head_tilt_left"], tilt)[0, 1] > 0.9
