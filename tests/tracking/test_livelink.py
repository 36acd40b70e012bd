from fractions import Fraction

import numpy as np
import pytest

from mimeline.errors import BadFile, MissingColumn
from mimeline.tracking import livelink
from mimeline.vocabulary import CHANNELS, EXPRESSIONS

KEYS = {"fps": "30", "timecode_base": 60, "angle_unit": "radians", "bad_values": "fail"}


def read(rows, tmp_path, **keys):
    path = tmp_path / "take.csv"
    rows.to_csv(path, index=False)
    return livelink.read(path, **KEYS | keys)


def test_coefficients_are_found_by_name_whatever_their_order(livelink_rows, tmp_path):
    shuffled = livelink_rows[["Timecode", *livelink_rows.columns.drop("Timecode")[::-1]]]
    motion = read(shuffled, tmp_path).motion
    for name in EXPRESSIONS:
        column = name[0].upper() + name[1:]
        assert motion[name].iloc[0] == pytest.approx(livelink_rows[column].iloc[0])


def test_a_jump_of_the_timecode_leaves_a_frame_that_is_not_valid(livelink_rows, tmp_path):
    take = read(livelink_rows, tmp_path)
    assert take.fps == Fraction(30)
    assert take.motion["frame"].tolist() == [0, 1, 2, 3, 4]
    assert take.motion["valid"].tolist() == [True, True, True, False, True]
    assert take.motion.loc[3, list(CHANNELS)].isna().all()


def test_angles_take_the_subjects_left_and_up_as_positive(livelink_rows, tmp_path):
    first = read(livelink_rows, tmp_path).motion.iloc[0]
    assert first["head_yaw_left"] == pytest.approx(-0.1)
    assert first["head_pitch_up"] == pytest.approx(-0.2)
    assert first["head_tilt_left"] == pytest.approx(0.3)
    assert first["gaze_left"] == pytest.approx(-0.2)
    assert first["gaze_up"] == pytest.approx(0.3)


def test_degrees_become_radians_only_where_the_config_says_so(livelink_rows, tmp_path):
    livelink_rows["HeadYaw"] = 30.0
    with pytest.raises(BadFile, match=r"Set ingest.livelink.angle_unit: degrees"):
        read(livelink_rows, tmp_path)
    motion = read(livelink_rows, tmp_path, angle_unit="degrees").motion
    assert motion["head_yaw_left"].iloc[0] == pytest.approx(-np.pi / 6)


def test_a_head_that_is_zero_throughout_was_not_measured(livelink_rows, tmp_path):
    livelink_rows[["HeadYaw", "HeadPitch", "HeadRoll"]] = 0.0
    motion = read(livelink_rows, tmp_path).motion
    assert motion[["head_yaw_left", "head_pitch_up", "head_tilt_left"]].isna().all(axis=None)
    assert motion["gaze_left"].notna().any()


def test_a_head_that_is_zero_was_not_measured_in_a_file_cut_off_either(livelink_rows, tmp_path):
    livelink_rows[["HeadYaw", "HeadPitch", "HeadRoll"]] = 0.0
    livelink_rows = livelink_rows.astype(object)
    livelink_rows.iloc[-1, -12:] = ""
    motion = read(livelink_rows, tmp_path, bad_values="mask").motion
    assert motion["head_yaw_left"].isna().all()
    assert motion["gaze_left"].notna().any()


def test_a_mirrored_take_swaps_sides_and_negates_yaw_tilt_and_gaze(livelink_rows, tmp_path):
    def other(name):
        for here, there in (("Left", "Right"), ("Right", "Left")):
            if name.endswith(here):
                return name.removesuffix(here) + there
            if name.startswith(f"{here}Eye"):
                return name.replace(here, there)
        return name

    mirrored = livelink_rows.rename(columns=other)
    for angle in ("HeadYaw", "HeadRoll", "LeftEyeYaw", "RightEyeYaw"):
        mirrored[angle] *= -1
    plain, turned = (read(rows, tmp_path).motion for rows in (livelink_rows, mirrored))
    for channel in CHANNELS.values():
        expected = channel.mirror_sign * plain[channel.mirror]
        np.testing.assert_allclose(turned[channel.name], expected, rtol=1e-6)


def test_a_row_that_comes_half_a_frame_early_or_late_is_no_gap(livelink_rows, tmp_path):
    livelink_rows["Timecode"] = [f"10:00:00:{tick:02d}" for tick in (4, 5, 8, 10)]
    assert read(livelink_rows, tmp_path).motion["valid"].tolist() == [True] * 4


def test_two_spellings_of_one_channel_are_refused(livelink_rows, tmp_path):
    with pytest.raises(BadFile, match="column eyeBlinkLeft twice"):
        read(livelink_rows.assign(eyeBlink_L=0.5), tmp_path)


def test_a_folder_is_no_take(tmp_path):
    with pytest.raises(BadFile):
        livelink.read(tmp_path, **KEYS)


def test_a_take_may_cross_midnight(livelink_rows, tmp_path):
    livelink_rows["Timecode"] = ["23:59:59:56", "23:59:59:58", "00:00:00:00", "00:00:00:02"]
    assert read(livelink_rows, tmp_path).motion["valid"].tolist() == [True] * 4


@pytest.mark.parametrize("cell", ["n/a", "nan", "", "inf"])
def test_a_cell_that_is_no_number_is_named_by_line_and_column(livelink_rows, tmp_path, cell):
    livelink_rows["BrowInnerUp"] = livelink_rows["BrowInnerUp"].astype(object)
    livelink_rows.loc[2, "BrowInnerUp"] = cell
    with pytest.raises(BadFile, match="line 4, column BrowInnerUp.*a number.*bad_values: mask"):
        read(livelink_rows, tmp_path)
    masked = read(livelink_rows, tmp_path, bad_values="mask").motion
    assert masked["valid"].tolist() == [True, True, False, False, True]


def test_a_file_without_a_header_is_refused(livelink_rows, tmp_path):
    path = tmp_path / "take.csv"
    livelink_rows.to_csv(path, index=False, header=False)
    with pytest.raises(BadFile, match="line 1.*a header with channel names"):
        livelink.read(path, **KEYS)


def test_a_missing_timecode_is_refused(livelink_rows, tmp_path):
    with pytest.raises(MissingColumn, match="Timecode"):
        read(livelink_rows.drop(columns="Timecode"), tmp_path)


def test_coefficients_in_per_cent_are_refused(livelink_rows, tmp_path):
    livelink_rows["JawOpen"] *= 100
    with pytest.raises(BadFile, match="between 0 and 1"):
        read(livelink_rows, tmp_path)


def test_a_wrong_rate_is_found_from_the_timecode(livelink_rows, tmp_path):
    with pytest.raises(BadFile, match=r"Set ingest.livelink.fps to 30"):
        read(livelink_rows, tmp_path, fps="60")
    with pytest.raises(BadFile, match="The rows come at about 30 per second"):
        read(livelink_rows, tmp_path, fps="12")


@pytest.mark.parametrize("content", [b"", b"\xff\xfe\x00garbage", b"Timecode,EyeBlinkLeft\n"])
def test_what_is_no_take_is_refused(tmp_path, content):
    path = tmp_path / "take.csv"
    path.write_bytes(content)
    with pytest.raises(BadFile):
        livelink.read(path, **KEYS)


def test_a_real_take_reads_with_its_dropped_frames_masked(real_data):
    take = livelink.read(real_data / "arkit_livelink" / "alex_rom_3.csv", **KEYS)
    assert take.motion["valid"].sum() == 4030
    assert (~take.motion["valid"]).sum() == 3
    assert take.motion["head_yaw_left"].isna().all()
    valid = take.motion[take.motion["valid"]]
    looks_left = valid["eyeLookOutLeft"] + valid["eyeLookInRight"]
    looks_left -= valid["eyeLookInLeft"] + valid["eyeLookOutRight"]
    assert np.corrcoef(valid["gaze_left"], looks_left)[0, 1] > 0.99
    looks_up = valid["eyeLookUpLeft"] - valid["eyeLookDownLeft"]
    assert np.corrcoef(valid["gaze_up"], looks_up)[0, 1] > 0.99
