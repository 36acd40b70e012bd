import os
import shutil
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.io import savemat

from mimeline.errors import BadFile, NoSuchFile
from mimeline.tracking.formats import emoca
from mimeline.tracking.take import Take

GOLDEN = Path(__file__).parents[1] / "golden" / "emoca"


def taken(folder: Path, bad_values: str = "fail") -> Take:
    return emoca.read(folder, fps="25", face=None, bad_values=bad_values)


def save(folder: Path, name: str, exp=None, pose=None) -> Path:
    """A frame's codes; the second number of the pose turns the head to the left."""
    frame = folder / name
    frame.mkdir(parents=True)
    np.save(frame / "exp.npy", np.zeros(50, "f4") if exp is None else exp)
    np.save(frame / "pose.npy", np.zeros(6, "f4") if pose is None else pose)
    return frame


def turned(angle: float) -> np.ndarray:
    return np.array([0, angle, 0, 0.1, 0, 0], "f4")


def test_folders_are_counted_from_1_and_a_missing_one_is_a_gap(tmp_path):
    for number in (2, 3, 5):
        save(tmp_path, f"{number:06d}_000", pose=turned(number / 10))
    take = taken(tmp_path)
    assert take.motion["valid"].tolist() == [False, True, True, False, True]
    np.testing.assert_allclose(take.motion["head_yaw_left"].dropna(), [0.2, 0.3, 0.5], atol=1e-6)
    assert take.first_frame == 2  # which the firewall tells


def test_a_folder_with_number_0_is_the_first_frame(tmp_path):
    for number in (0, 1):
        save(tmp_path, f"{number:06d}_000")
    take = taken(tmp_path)
    assert len(take.motion) == 2
    assert take.first_frame == 0


@pytest.mark.parametrize("home", ["", "EMOCA_v2_lr_mse_20", "results/EMOCA"])
def test_the_frames_lie_in_the_folder_or_in_their_models(tmp_path, home):
    (tmp_path / "clip" / "detections").mkdir(parents=True)
    save(tmp_path / "clip" / home, "000001_000")
    assert emoca.holds(tmp_path / "clip")
    assert len(taken(tmp_path / "clip").motion) == 1


def test_the_codes_of_two_models_are_refused(tmp_path):
    for model in ("EMOCA", "DECA"):
        save(tmp_path / model, "000001_000")
    assert not emoca.holds(tmp_path)
    with pytest.raises(BadFile, match="DECA and in EMOCA"):
        taken(tmp_path)


def test_clips_that_are_named_by_numbers_are_no_frames(tmp_path):
    save(tmp_path / "001", "000001_000")
    save(tmp_path / "002", "000001_000")
    assert not emoca.holds(tmp_path)
    assert emoca.holds(tmp_path / "001")


def test_of_several_faces_the_first_is_taken_and_it_is_told(tmp_path, caplog):
    save(tmp_path, "000001_001", pose=turned(0.3))
    save(tmp_path, "000001_000", pose=turned(0.1))
    assert taken(tmp_path).motion["head_yaw_left"].item() == pytest.approx(0.1)
    assert "several faces in 1 frames" in caplog.text


def test_two_videos_in_a_folder_are_refused(tmp_path):
    save(tmp_path, "a_frame0001")
    save(tmp_path, "b_frame0001")
    with pytest.raises(BadFile, match="_frame0001 and ._frame0001"):
        taken(tmp_path)


def test_decas_codes_are_read_from_mat_files_counted_from_0(tmp_path):
    for number in (0, 1):
        name = f"talk_frame{number:04d}"
        (tmp_path / name).mkdir()
        codes = {"exp": np.full((1, 50), 0.5), "pose": turned(0.2)[None], "verts": np.ones((9, 3))}
        savemat(tmp_path / name / f"{name}.mat", codes)
    take = taken(tmp_path)
    np.testing.assert_allclose(take.motion["head_yaw_left"], 0.2, atol=1e-6)
    assert take.coefficients["flame"]["exp049"].tolist() == [0.5, 0.5]
    assert take.first_frame is None


@pytest.mark.parametrize(("first", "valid"), [(0, [1, 1]), (1, [1, 1]), (3, [0, 0, 1, 1])])
def test_decas_frames_are_counted_from_1_where_they_do_not_begin_with_0(tmp_path, first, valid):
    for number in (first, first + 1):
        save(tmp_path, f"talk_frame{number:04d}")
    take = taken(tmp_path)
    assert take.motion["valid"].tolist() == [bool(v) for v in valid]
    assert take.first_frame == (first or None)


def test_decas_mat_without_codes_says_what_to_do(tmp_path):
    (tmp_path / "talk_frame0000").mkdir()
    savemat(tmp_path / "talk_frame0000" / "talk_frame0000.mat", {"verts": np.ones((9, 3))})
    with pytest.raises(BadFile, match="exp.*no such variable.*add exp and pose"):
        taken(tmp_path)


def test_gaze_and_neck_are_not_measured_and_the_jaw_is(tmp_path):
    save(tmp_path, "000001_000", pose=turned(0))
    take = taken(tmp_path)
    assert not take.origins["gaze_left"].measured
    assert take.origins["jawOpen"].measured
    assert take.motion["gaze_left"].isna().all()
    assert take.motion["jawOpen"].item() > 0.1
    assert take.coefficients["flame"].filter(like="neck").isna().all(axis=None)


def test_a_frame_whose_codes_are_missing_fails_or_is_masked(tmp_path):
    for number in (1, 2, 3):
        save(tmp_path, f"{number:06d}_000")
    (tmp_path / "000002_000" / "pose.npy").unlink()
    with pytest.raises(BadFile, match="000002_000"):
        taken(tmp_path)
    assert taken(tmp_path, "mask").motion["valid"].tolist() == [True, False, True]


def test_a_frame_whose_codes_are_half_written_fails_or_is_masked_unless_all_are(tmp_path):
    for number in (1, 2, 3):
        save(tmp_path, f"{number:06d}_000")
    for number, content in ((2, b"\x93NUMPY"), (3, b"")):
        (tmp_path / f"{number:06d}_000" / "exp.npy").write_bytes(content)
    with pytest.raises(BadFile, match="exp.npy"):
        taken(tmp_path)
    assert taken(tmp_path, "mask").motion["valid"].tolist() == [True, False, False]
    (tmp_path / "000001_000" / "pose.npy").write_bytes(b"")
    with pytest.raises(BadFile, match="pose.npy"):
        taken(tmp_path, "mask")


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_number_that_is_none_fails_or_masks_its_frame(tmp_path, value):
    for number in (1, 2):
        save(
            tmp_path,
            f"{number:06d}_000",
            exp=np.array([0] * 49 + [value] * (number - 1) + [0] * (2 - number), "f4"),
        )
    with pytest.raises(BadFile, match="frame 1"):
        taken(tmp_path)
    assert taken(tmp_path, "mask").motion["valid"].tolist() == [True, False]


@pytest.mark.parametrize(
    "exp",
    [
        np.zeros(49, "f4"),
        np.zeros(50, "c16"),
        np.zeros((1, 1, 50)),
        np.zeros((25, 2), "f4"),
        np.array([print] * 50, dtype=object),
        np.zeros(50, [("a", "f4")]),
        np.array("text"),
    ],
)
def test_codes_of_another_shape_or_type_are_refused(tmp_path, exp):
    save(tmp_path, "000001_000", exp=exp)
    for bad_values in ("fail", "mask"):
        with pytest.raises(BadFile, match="exp.npy"):
            taken(tmp_path, bad_values)


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\x93NUMPY\x01\x00",
        b"\x93NUMPY\x01\x00\xff\xff{",
        b"\x93NUMPY\x02\x00\x10\x00\x00\x00" + b" " * 60,
        b"\x93NUMPY\x01\x00\x76\x00" + b"(" * 118,
        b"\x93NUMPY\x01\x00\x76\x00"
        + b"{'descr': '<f4', 'fortran_order': False, 'shape': (10000000000,)}".ljust(118),
        b"PK\x03\x04" + b"\0" * 100,
        bytes(10_000),
    ],
)
def test_spoilt_headers_are_refused(tmp_path, content):
    (save(tmp_path, "000001_000") / "exp.npy").write_bytes(content)
    with pytest.raises(BadFile, match="exp.npy"):
        taken(tmp_path)


def test_pipes_and_links_do_not_stall_or_leak(tmp_path):
    frame = save(tmp_path, "000001_000")
    (frame / "exp.npy").unlink()
    os.mkfifo(frame / "exp.npy")
    with pytest.raises(BadFile):
        taken(tmp_path)
    (frame / "exp.npy").unlink()
    secret = tmp_path / "secret"
    secret.write_text("password: hidden " * 20)
    (frame / "exp.npy").symlink_to(secret)
    with pytest.raises(BadFile) as error:
        taken(tmp_path)
    assert "hidden" not in str(error.value)
    (tmp_path / "000002_000").symlink_to(tmp_path)  # a circle
    (frame / "exp.npy").unlink()
    with pytest.raises(BadFile):
        taken(tmp_path)


def test_what_is_no_folder_of_codes_is_refused(tmp_path):
    with pytest.raises(NoSuchFile):
        taken(tmp_path / "none")
    (tmp_path / "file").write_text("")
    for path in (tmp_path, tmp_path / "file"):
        assert not emoca.holds(path)
        with pytest.raises(BadFile):
            taken(path)


def test_a_number_beyond_every_take_is_refused(tmp_path):
    save(tmp_path, "999999999_000")
    with pytest.raises(BadFile):
        taken(tmp_path)


@settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(data=st.data())
def test_spoilt_bytes_give_our_error_or_a_take(data, tmp_path):
    folder = tmp_path / "clip"
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(GOLDEN / "turns_left", folder)
    path = folder / "000003_000" / data.draw(st.sampled_from(["exp.npy", "pose.npy"]))
    content = bytearray(path.read_bytes())
    for place in data.draw(st.lists(st.integers(0, len(content) - 1), min_size=1, max_size=4)):
        content[place] = data.draw(st.integers(0, 255))
    path.write_bytes(content[: data.draw(st.integers(0, len(content)))])
    try:
        taken(folder, "mask")
    except BadFile as error:
        assert "\n" not in str(error)
