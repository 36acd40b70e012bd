import re
from fractions import Fraction

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mimeline.errors import BadFile, MissingColumn
from mimeline.tracking.formats import livelink
from mimeline.tracking.formats.livelink import ROTATIONS, SHAPES
from mimeline.vocabulary import CHANNELS, EXPRESSIONS, GAZE, HEAD

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


def camel(name):
    return name[0].lower() + name[1:]


def short(name):
    return re.sub("(Left|Right)$", lambda side: f"_{side[0][0]}", camel(name))


VARIANTS = {
    "camelCase": lambda rows: rows.rename(columns=camel),
    "_L and _R": lambda rows: rows.rename(columns=short),
    "right before left": lambda rows: rows[rows.columns[::-1]],
    "without eye Roll": lambda rows: rows.drop(columns=["LeftEyeRoll", "RightEyeRoll"]).assign(
        BlendShapeCount=59
    ),
    "52 counted": lambda rows: rows.assign(BlendShapeCount=52),
    "without rotations": lambda rows: rows[["Timecode", "BlendShapeCount", *SHAPES]].assign(
        BlendShapeCount=52
    ),
    "without TongueOut": lambda rows: rows.drop(columns=["TongueOut", *ROTATIONS]).assign(
        BlendShapeCount=51
    ),
    "without a count": lambda rows: rows.drop(columns="BlendShapeCount"),
    "with an index": lambda rows: rows.reset_index().rename(columns={"index": ""}),
    "whole ticks": lambda rows: rows.assign(
        Timecode=[f"10:00:{t}" for t in ("00:56", "00:58", "01:00", "01:04")]
    ),
}
SPELLINGS = {
    "CRLF": lambda text: text.replace("\n", "\r\n"),
    "BOM": lambda text: "\ufeff" + text,
    "trailing commas": lambda text: text.replace("\n", ",\n"),
    "trailing commas in rows": lambda text: text.replace("\n", ",\n").replace(",\n", "\n", 1),
    "quoted": lambda text: re.sub(r"[^,\n]+", lambda cell: f'"{cell[0]}"', text),
    "blank lines": lambda text: text.replace("\n", "\n\n"),
    "spaces": lambda text: text.replace(",", ", "),
}


@pytest.mark.parametrize("variant", VARIANTS)
def test_every_header_that_is_in_use_gives_the_same_take(livelink_rows, tmp_path, variant):
    rows = VARIANTS[variant](livelink_rows)
    plain, motion = read(livelink_rows, tmp_path).motion, read(rows, tmp_path).motion
    held = {livelink.canonical(name) for name in rows}
    angles = [*HEAD, *GAZE] if any(name.casefold() == "headyaw" for name in rows) else []
    for name in CHANNELS:
        if name in held or name in angles:
            np.testing.assert_array_equal(motion[name], plain[name])
        else:
            assert motion[name].isna().all()


@pytest.mark.parametrize("spelling", SPELLINGS)
def test_every_spelling_of_the_file_gives_the_same_take(livelink_rows, tmp_path, spelling):
    plain = read(livelink_rows, tmp_path).motion
    path = tmp_path / "take.csv"
    path.write_bytes(SPELLINGS[spelling](path.read_text()).encode())
    assert livelink.holds(path)
    pd.testing.assert_frame_equal(livelink.read(path, **KEYS).motion, plain)


def test_a_count_that_contradicts_the_header_is_refused(livelink_rows, tmp_path):
    livelink_rows.loc[2, "BlendShapeCount"] = 53
    with pytest.raises(BadFile, match="line 4, column BlendShapeCount: found 53.*52 or 61"):
        read(livelink_rows, tmp_path)


def test_a_take_without_a_channel_is_refused(livelink_rows, tmp_path):
    with pytest.raises(MissingColumn, match="columns as EyeBlinkLeft"):
        read(livelink_rows[["Timecode", "BlendShapeCount"]], tmp_path)


def test_drop_frame_counting_leaves_no_gap_where_a_minute_begins(livelink_rows, tmp_path):
    def valid(times, base):
        rows = pd.concat([livelink_rows.iloc[:1]] * len(times)).assign(Timecode=times)
        take = read(rows, tmp_path, fps="30000/1001", timecode_base=base)
        return take.motion["valid"].tolist()

    assert valid(["10:00:59;28", "10:00:59;29", "10:01:00;02", "10:01:00;03"], 30) == [True] * 4
    assert valid(["10:09:59;29", "10:10:00;00"], 30) == [True] * 2
    assert valid(["23:59:59;29", "00:00:00;00"], 30) == [True] * 2
    assert valid(["10:00:59;58.5", "10:01:00;04.5"], 60) == [True] * 2
    rows = ["10:00:59:28", "10:00:59:29", "10:01:00:02"]
    assert valid(rows, 30) == [True, True, False, False, True]


@pytest.mark.parametrize(
    ("times", "base", "message"),
    [
        (["10:01:00;01", "10:01:00;02"], 30, "line 2.*drop-frame counting of 30 or 60"),
        (["10:01:30;01", "10:01:30;02"], 25, "line 2.*drop-frame counting of 30 or 60"),
        (["10:01:30;01", "10:01:30:02"], 30, "line 3.*the same mark"),
        (["10:01:30:29", "10:01:30:30"], 30, "line 3.*below 30.*timecode_base"),
        (["24:00:00:00", "24:00:00:01"], 30, "line 2.*a time of day"),
        (["10:00:00:00", "10:00:60:00"], 30, "line 3.*expected HH:MM:SS:FF"),
        (["10:00:00:00", "10:00:00:01.x"], 30, "line 3.*expected HH:MM:SS:FF"),
        (["10:00:00:00", ""], 30, "line 3.*expected HH:MM:SS:FF"),
        (["10:00:00:01", "10:00:00:01"], 30, "line 3.*a later frame.*share their timecode"),
        (["10:00:00:01", "10:00:00:00"], 30, "line 3.*a later frame.*in their order"),
    ],
)
def test_a_timecode_that_cannot_be_is_found_where_it_stands(
    livelink_rows, tmp_path, times, base, message
):
    with pytest.raises(BadFile, match=message):
        read(livelink_rows.iloc[:2].assign(Timecode=times), tmp_path, timecode_base=base)


def test_every_channel_tells_how_it_was_had(livelink_rows, tmp_path):
    livelink_rows["HeadRoll"] = 0.0
    rows = livelink_rows.drop(columns=["TongueOut", "RightEyePitch", "BlendShapeCount"])
    origins = read(rows, tmp_path).origins
    assert list(origins) == list(CHANNELS)
    assert origins["mouthSmileLeft"].text == "column MouthSmileLeft"
    assert origins["head_yaw_left"].text == "column -HeadYaw"
    assert origins["gaze_left"].text == "mean of columns -LeftEyeYaw and -RightEyeYaw"
    unmeasured = {name: origin.text for name, origin in origins.items() if not origin.measured}
    assert set(unmeasured) == {"tongueOut", "head_tilt_left", "gaze_up"}
    assert unmeasured["head_tilt_left"] == "column HeadRoll is 0 or empty throughout"
    assert "RightEyePitch" in unmeasured["gaze_up"]


def test_only_a_live_link_table_holds_one(livelink_rows, pyfeat_rows, tmp_path):
    path = tmp_path / "take.csv"
    for rows, held in ((livelink_rows, True), (pyfeat_rows, False)):
        rows.to_csv(path, index=False)
        assert livelink.holds(path) == held
    path.write_bytes(b"\xff\xfe\x00")
    assert not livelink.holds(path)
    assert not livelink.holds(tmp_path)


def test_the_header_that_is_written_names_every_coefficient_once():
    assert sorted(camel(name) for name in SHAPES) == sorted(EXPRESSIONS)
    assert len(livelink.HEADER) == 63


@st.composite
def motions(draw) -> pd.DataFrame:
    """Rows of table motion; the first frames and the last are valid, others may not be."""
    n_frames = draw(st.integers(1, 40))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    motion = pd.DataFrame({"frame": np.arange(n_frames)})
    motion["valid"] = rng.random(n_frames) < draw(st.sampled_from([0.7, 0.95, 1.0]))
    motion.loc[motion["frame"].isin([0, 1, n_frames - 1]), "valid"] = True
    for name in CHANNELS:
        low, high = (-0.5, 1.5) if name in EXPRESSIONS else (-3.0, 3.0)
        motion[name] = rng.uniform(low, high, n_frames).astype("float32")
    motion.loc[~motion["valid"], list(CHANNELS)] = np.nan
    return motion


@settings(max_examples=30, deadline=None)
@given(
    motion=motions(),
    fps=st.sampled_from(["30", "30000/1001", "25", "24", "60", "50"]),
    start=st.floats(0, 86399),
    base=st.sampled_from([60, 120]),
)
def test_reading_what_was_written_gives_the_motion_again(
    motion, fps, start, base, tmp_path_factory
):
    path = tmp_path_factory.mktemp("written") / "take.csv"
    assert livelink.write(path, motion, Fraction(fps), start, base) == []
    take = livelink.read(path, fps=fps, timecode_base=base, angle_unit="radians", bad_values="fail")
    assert take.fps == Fraction(fps)
    assert take.motion["valid"].tolist() == motion["valid"].tolist()
    expected = motion[list(CHANNELS)].astype("float32")
    np.testing.assert_allclose(take.motion[list(CHANNELS)], expected, rtol=1e-6, atol=1e-9)


def test_what_was_not_measured_is_written_as_0_and_named(livelink_rows, tmp_path):
    motion = read(livelink_rows, tmp_path).motion
    motion["jawOpen"] = np.nan
    motion["head_yaw_left"] = np.nan
    path = tmp_path / "written.csv"
    assert livelink.write(path, motion, Fraction(30)) == ["jawOpen", "head_yaw_left"]
    again = livelink.read(path, **KEYS).motion
    assert (again.loc[again["valid"], "jawOpen"] == 0).all()
    assert again["head_yaw_left"].isna().all()
    with pytest.raises(BadFile, match="without a valid frame"):
        livelink.write(path, motion.assign(valid=False), Fraction(30))
