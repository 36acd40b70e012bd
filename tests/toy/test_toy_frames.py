"""The toy world as .frame folders, against the same world as Live Link Face takes."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from mimeline.errors import MimelineError
from mimeline.face.load import load_face
from mimeline.toy import frame_files, make
from mimeline.tracking.formats import livelink, metrical_tracker
from mimeline.vocabulary import CHANNELS

PEOPLE, CLIPS, SEED = 4, 32, 5  # as many clips as every fault but the videos' needs
# What the format cannot hold as it was: both sides at once, and looks of another slope.
UNTOLD = [name for name in CHANNELS if name.startswith(("eyeLook", "jawLeft", "jawRight"))]


def world(root, tracker: str, clips: int = CLIPS) -> SimpleNamespace:
    made = SimpleNamespace(root=root, data=root / "data", truth=root / "truth")
    make(made.data, made.truth, PEOPLE, clips, SEED, 0, 64, tracker)
    return made


@pytest.fixture(scope="module")
def frames(tmp_path_factory):
    return world(tmp_path_factory.mktemp("toy") / "deep" / "frames", "metrical_tracker")


@pytest.fixture(scope="module")
def takes(tmp_path_factory):
    return world(tmp_path_factory.mktemp("toy") / "takes", "livelink")


@pytest.fixture(scope="module")
def faults(frames) -> dict[str, str]:
    """Clip by fault; of those that there are several of, the last."""
    return pd.read_csv(frames.truth / "faults.csv").set_index("fault")["clip_id"].to_dict()


def frame_take(made, clip_id: str):
    return metrical_tracker.read(
        made.data / "metrical_tracker" / clip_id,
        fps="30",
        face=made.data / "face_model.npz",
        bad_values="fail",
    )


def csv_take(made, clip_id: str):
    path = made.data / "livelink" / f"{clip_id}.csv"
    return livelink.read(path, fps="30", timecode_base=60, angle_unit="radians", bad_values="fail")


def test_everything_but_the_tracking_results_is_the_same(frames, takes):
    for name in ("celebvtext_info.json", "annotations.json", "head_pose.csv"):
        assert (frames.data / name).read_bytes() == (takes.data / name).read_bytes()
    for path in takes.truth.iterdir():
        assert path.read_bytes() == (frames.truth / path.name).read_bytes()
    assert not (takes.data / "face_model.npz").exists() and not (frames.data / "livelink").exists()


def test_the_readers_find_the_same_motion_in_both(frames, takes, faults):
    spoilt = set(pd.read_csv(frames.truth / "faults.csv")["clip_id"])
    sound = [p.stem for p in sorted((takes.data / "livelink").iterdir()) if p.stem not in spoilt]
    for clip_id in [*sound[:4], faults["rows_absent"], faults["tracking_lost"]]:
        ours, theirs = frame_take(frames, clip_id).motion, csv_take(takes, clip_id).motion
        np.testing.assert_array_equal(ours["valid"], theirs["valid"])
        for name in CHANNELS:
            if name not in UNTOLD:
                np.testing.assert_allclose(ours[name], theirs[name], atol=2e-4, err_msg=name)


def test_what_cannot_be_read_there_cannot_be_read_here(frames, takes, faults):
    for fault in ("no_header", "text_cell", "nan_cell", "truncated", "missing_file", "no_face"):
        for read, made in ((csv_take, takes), (frame_take, frames)):
            with pytest.raises(MimelineError):
                read(made, faults[fault])


def test_a_hostile_frame_runs_nothing_and_all_else_of_its_clip_is_sound(frames, faults):
    folder = frames.data / "metrical_tracker" / faults["no_header"]
    with pytest.raises(MimelineError, match=r"00000\.frame"):
        frame_take(frames, faults["no_header"])
    take = metrical_tracker.read(folder, fps="30", face=None, bad_values="mask")
    assert take.motion["valid"].tolist() == [False] + [True] * (len(take.motion) - 1)


def test_a_clip_without_a_face_has_an_empty_folder(frames, faults):
    folder = frames.data / "metrical_tracker" / faults["no_face"]
    assert folder.is_dir() and not list(folder.rglob("*.frame"))
    assert not (frames.data / "metrical_tracker" / faults["missing_file"]).exists()


def test_the_face_model_is_told_as_flames_and_has_no_channel_of_its_own(frames):
    face = load_face(frames.data / "face_model.npz")
    assert len(face.shape_names) == 100 and face.joint_names[2] == "jaw"
    known = load_face(None)
    eyes = [joint.centre for joint in known.joints if joint.name.endswith("eye")]
    np.testing.assert_allclose([joint.centre for joint in face.joints[3:]], eyes, atol=1e-4)
    coefficients = frame_files.coefficients(
        pd.DataFrame({name: [float(name == "mouthFunnel")] for name in CHANNELS})
    )
    expression = coefficients.filter(like="exp").to_numpy()[0]
    assert (np.abs(expression) > 0.01).sum() > 50
    shown = face.vertices(expression[None])[0] - face.neutral
    wanted = known.shapes[known.shape_names.index("mouthFunnel")]
    np.testing.assert_allclose(shown, wanted, atol=1e-6)


def test_the_same_seed_writes_the_same_frames(tmp_path):
    first, second = (world(tmp_path / name, "metrical_tracker", clips=5) for name in "ab")
    paths = [path for path in first.data.rglob("*") if path.is_file()]
    assert len(paths) > 500
    for path in paths:
        assert path.read_bytes() == (second.data / path.relative_to(first.data)).read_bytes()


def test_the_hostile_id_writes_nothing_outside(frames):
    assert {path.name for path in frames.root.parent.iterdir()} == {"frames"}
    assert {path.name for path in frames.root.iterdir()} == {"data", "truth"}
    assert not [path for path in frames.root.rglob("*") if "outside" in path.name]
