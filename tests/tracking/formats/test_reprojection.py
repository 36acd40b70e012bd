"""Landmarks against a head in FLAME's layout that has the embedded face's topology, or another."""

from dataclasses import replace

import cv2
import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.archives.torch_saved import read_saved, write_saved
from mimeline.errors import BadFile
from mimeline.face.load import load_face
from mimeline.face.model import Face
from mimeline.face.rotations import turned
from mimeline.tables import COEFFICIENTS
from mimeline.toy import frame_files
from mimeline.tracking import loss
from mimeline.tracking.formats import metrical_tracker, reprojection
from mimeline.tracking.ingest import ingest

FRAMES, SPOILT = 5, 3
JAW = 0.25  # radians about x: open
IDENTITY = {"shape000": 1.5, "shape004": -2.0}


@pytest.fixture(scope="module")
def flame(tmp_path_factory):
    """A file in FLAME's layout: identity 0 makes the face larger, identity 4 its jaw wider."""
    path = tmp_path_factory.mktemp("face") / "face.npz"
    frame_files.write_face(path)
    with np.load(path) as file:
        arrays = dict(file)
    neutral, directions = arrays["v_template"], arrays["shapedirs"]
    directions[..., 0] = 0.03 * (neutral - neutral.mean(0))
    directions[..., 4] = arrays["weights"][:, [2]] * neutral * [0.05, 0, 0]
    arrays["posedirs"] = np.random.default_rng(5).normal(0, 0.005, arrays["posedirs"].shape)
    np.savez(path, **arrays)
    return path


@pytest.fixture(scope="module")
def model(flame) -> Face:
    return load_face(flame)


@pytest.fixture
def take(tmp_path, flame, model):
    """The folder of a take: its head turns and nods, its face moves, its landmarks agree."""
    rng, n = np.random.default_rng(4), np.arange(FRAMES)
    names = [c for c in COEFFICIENTS["flame"].schema.names[2:] if not c.startswith(("head", "nec"))]
    rows = pd.DataFrame(0.0, index=n, columns=names)
    expression = [name for name in names if name.startswith("exp")]
    rows[expression] = rng.normal(0, 0.3, (FRAMES, len(expression)))
    rows["jaw_x"] = JAW * n / FRAMES
    folder = tmp_path / "clip"
    metrical_tracker.write(folder, rows, turned(0.15 * n, -0.05 * n, 0.04 * n))
    identity = np.zeros((1, 300), np.float32)
    for name, value in IDENTITY.items():
        identity[0, int(name[5:])] = value
    person = model.of(IDENTITY)
    jaw = np.stack([cv2.Rodrigues(np.array([angle, 0, 0]))[0] for angle in rows["jaw_x"]])
    vertices = person.vertices(rows[expression].to_numpy(), {"jaw": jaw})
    (folder / "kpt").mkdir()
    for frame in n:
        turn, shift, K = change(
            folder,
            frame,
            flame={"shape": identity},
            opencv={
                "t": np.float32([[0.02, -0.01, 0.9]]),
                "K": np.float32([[[2400, 0, 250], [0, 2450, 262], [0, 0, 1]]]),
            },
        )
        shown = model_landmarks(vertices[frame])
        pixels, _ = cv2.projectPoints(shown, cv2.Rodrigues(turn)[0], shift, K, None)
        np.save(folder / "kpt" / f"{frame + 1:05d}.npy", pixels[:, 0])
    return folder


def model_landmarks(vertices: np.ndarray) -> np.ndarray:
    return np.float64(vertices[load_face(None).landmarks])


def change(folder, frame: int, **groups) -> list[np.ndarray]:
    """Set fields of a frame, or take away those that are None; its camera R, t and K."""
    path = folder / "checkpoint" / f"{frame:05d}.frame"
    content = read_saved(path, "")
    for group, fields in groups.items():
        merged = content[group] | fields
        content[group] = {name: value for name, value in merged.items() if value is not None}
    write_saved(path, content)
    return [np.float64(content["opencv"][name][0]) for name in "RtK" if name in content["opencv"]]


def read(folder, face):
    return metrical_tracker.read(folder, fps="25", face=face, bad_values="fail")


def spoil(folder, shift=(60, 0)):
    """Move a frame's landmarks by pixels, of which some 230 lie between the eyes' corners."""
    path = folder / "kpt" / f"{SPOILT + 1:05d}.npy"
    np.save(path, np.load(path) + shift)


def errors(folder, face) -> np.ndarray:
    return read(folder, face).motion["tracker_loss"].to_numpy()


def test_landmarks_of_the_very_head_leave_no_error(take, flame):
    found = read(take, flame)
    assert found.loss == loss.REPROJECTION
    assert found.motion["tracker_loss"].max() < 1e-4


def test_a_spoilt_frame_stands_out_in_distances_between_the_eyes(take, flame, model):
    spoil(take, (30, -40))
    eyes = model_landmarks(model.of(IDENTITY).neutral)[[36, 45]]
    apart = 2400 / 0.9 * np.linalg.norm(eyes[0] - eyes[1])  # pixels, but for the head's depth
    found = errors(take, flame)
    assert found[SPOILT] == pytest.approx(50 / apart, rel=0.1)
    assert np.delete(found, SPOILT).max() < 1e-4


@pytest.mark.parametrize(
    "fields",
    [
        {"flame": {"shape": np.zeros((1, 300), np.float32)}},
        {"flame": {"exp": np.zeros((1, 100), np.float32)}},
        {"flame": {"jaw": np.float32([[1, 0, 0, 0, 1, 0]])}},
        {"opencv": {"t": np.float32([[0.04, 0, 0.9]])}},
        {"opencv": {"K": np.float32([[[2000, 0, 250], [0, 2000, 262], [0, 0, 1]]])}},
    ],
    ids=["shape", "exp", "jaw", "t", "K"],
)
def test_everything_that_places_the_head_counts(take, flame, fields):
    change(take, SPOILT, **fields)
    found = errors(take, flame)
    assert found[SPOILT] > 0.01 and np.delete(found, SPOILT).max() < 1e-4


def test_jaw_line_brows_and_eyelids_do_not_count(take, flame):
    path = take / "kpt" / "00002.npy"
    points = np.load(path)
    points[np.r_[0:27, 37:39, 40:42, 43:45, 46:48]] += 50
    np.save(path, points)
    assert errors(take, flame).max() < 1e-4


@pytest.mark.parametrize(
    "fields",
    [
        {"opencv": {"t": np.float32([[0, 0, -0.9]])}},
        {"opencv": {"K": np.zeros((1, 3, 3), np.float32)}},
        {"flame": {"shape": np.full((1, 300), 3e38, np.float32)}},
    ],
    ids=["behind", "no camera", "overflow"],
)
def test_a_head_that_no_camera_sees_is_infinitely_far_off(take, flame, fields):
    change(take, SPOILT, **fields)
    assert np.flatnonzero(np.isinf(errors(take, flame))).tolist() == [SPOILT]


def test_a_frame_without_landmarks_or_camera_has_no_loss(take, flame):
    (take / "kpt" / "00001.npy").unlink()
    change(take, 2, opencv={"K": None})
    found = read(take, flame)
    assert found.loss and found.motion["valid"].all()
    assert np.flatnonzero(found.motion["tracker_loss"].isna()).tolist() == [0, 2]


def test_a_frame_of_two_cameras_has_no_loss(take, flame):
    turned_away = np.float32([[[-1, 0, 0], [0, -1, 0], [0, 0, 1]]])
    change(take, SPOILT, opencv={"R": turned_away})
    found = metrical_tracker.read(take, fps="25", face=flame, bad_values="mask").motion
    assert np.flatnonzero(~found["valid"]).tolist() == [SPOILT]
    assert np.flatnonzero(found["tracker_loss"].isna()).tolist() == [SPOILT]


def test_a_gap_in_the_numbering_leaves_the_losses_at_their_frames(take, flame):
    spoil(take)
    (take / "checkpoint" / "00001.frame").unlink()
    found = errors(take, flame)
    assert np.isnan(found[1]) and found[SPOILT] > 0.1 and np.nanmin(found) < 1e-4


@pytest.mark.parametrize("lacking", ["flame.shape", "opencv.t", "opencv.K", "kpt", "face"])
def test_without_a_piece_there_is_no_loss(take, flame, lacking):
    group, _, field = lacking.partition(".")
    for frame in range(FRAMES if field else 0):
        change(take, frame, **{group: {field: None}})
    if lacking == "kpt":
        (take / "kpt").rename(take / "other")
    found = read(take, None if lacking == "face" else flame)
    assert found.motion["valid"].all() and found.motion["tracker_loss"].isna().all()
    assert found.loss == ""


def test_a_shape_of_another_layout_is_refused_only_where_it_is_needed(take, flame):
    change(take, 2, flame={"shape": np.zeros((3, 100), np.float32)})
    assert read(take, None).motion["valid"].all()
    with pytest.raises(BadFile, match="flame.shape"):
        read(take, flame)


def test_fewer_identities_leave_the_others_at_rest(take, flame):
    for frame in range(FRAMES):
        content = read_saved(take / "checkpoint" / f"{frame:05d}.frame", "")
        change(take, frame, flame={"shape": content["flame"]["shape"][:, :50]})
    assert errors(take, flame).max() < 1e-4


def test_a_face_that_is_no_flame_is_refused(tmp_path):
    face, V = load_face(None), len(load_face(None).neutral)
    arrays = {"neutral": face.neutral, "triangles": face.triangles}
    np.savez(tmp_path / "other.npz", **arrays, shapes=np.zeros((1, V, 3)), shape_names=["jawOpen"])
    shapes = (300,), (100,), (3, 3), (3, 3), (3,), (3, 3), (68, 2)
    with pytest.raises(BadFile, match="expected FLAME"):
        reprojection.reprojection_error(
            tmp_path / "other.npz", *(np.zeros((1, *shape)) for shape in shapes)
        )


def ledger_of(folder, face: str | None) -> pd.DataFrame:
    """The ledger of a run over the one clip, at the limits of the default configuration."""
    row = {"clip_id": "clip", "source_id": "a", "start_s": 0, "end_s": FRAMES / 25, "shard": 0}
    empty = {name: [] for name in ("actions", "emotions", "attributes", "texts")}
    clips = pd.DataFrame([row | empty], columns=tables.CLIPS.schema.names)
    data = folder.parent
    tables.write(tables.CLIPS, clips, data / "clips.parquet")
    out = {n: data / f"{n}.parquet" for n in ("motion", "origins", "kept", "ledger")}
    ingest(
        data / "clips.parquet",
        data,
        **out,
        coefficients=[data / f"{name}.parquet" for name in tables.COEFFICIENTS],
        format="metrical_tracker",
        options={"folder": ".", "fps": "25", "face": face},
        mirrored=False,
        bad_values="fail",
        max_missing=0.1,
        max_loss=None,
        max_reprojection=0.1,
    )
    ledger = tables.read(tables.LEDGER, out["ledger"])
    return ledger[ledger["rule"] == "tracking_loss"]


def test_a_clip_with_a_spoilt_frame_is_dropped_by_that_frame(take, flame):
    assert ledger_of(take, str(flame)).empty
    spoil(take)
    (row,) = ledger_of(take, str(flame)).itertuples()
    assert (row.status, row.first_frame, row.last_frame) == ("dropped", SPOILT, SPOILT)
    assert row.unit == "eye distances" and row.value > row.limit == 0.1


def test_without_a_face_the_ledger_says_that_the_rule_was_not_applied(take):
    spoil(take)
    (row,) = ledger_of(take, None).itertuples()
    assert (row.status, row.detail[:11]) == ("kept", "not applied")


def test_triangles_in_another_order_leave_the_landmarks_where_they_are(model):
    other = replace(model, triangles=model.triangles[::-1])
    corners, shares = reprojection.compared_on(other)
    found = np.einsum("mcx,mc->mx", other.neutral[corners], shares)
    own = model_landmarks(model.neutral)
    off = np.linalg.norm(found - own[reprojection.COMPARED], axis=1)
    assert off.max() < 0.05 * np.linalg.norm(own[36] - own[45])


def test_on_another_topology_the_compared_landmarks_come_near_its_own(real_data):
    """With room below the default limit of 0.1."""
    other = load_face(real_data / "face" / "ict_facekit_compact.npz")
    corners, shares = reprojection.compared_on(replace(other, landmarks=None))
    found = np.einsum("mcx,mc->mx", other.neutral[corners], shares)
    own = other.neutral[other.landmarks]
    off = np.linalg.norm((found - own[reprojection.COMPARED])[:, :2], axis=1)
    assert np.sqrt((off**2).mean()) < 0.05 * np.linalg.norm(own[36] - own[45])
