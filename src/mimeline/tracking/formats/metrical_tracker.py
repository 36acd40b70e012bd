"""metrical-tracker: a folder of .frame files per clip (Zielonka et al. 2022).

A .frame is what torch.save makes of NumPy arrays: FLAME's coefficients, and the camera twice, in
PyTorch3D's axes and in OpenCV's. FLAME's own head stays at rest; the camera goes round it, and so
tells the head's pose.
"""

import re
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline.archives.torch_saved import write_saved
from mimeline.errors import BadFile, unreadable
from mimeline.tracking.convention import Convention
from mimeline.tracking.formats.flame_take import EXPRESSION, EYELIDS, joint, take_of
from mimeline.tracking.formats.kpt import landmarks_of
from mimeline.tracking.formats.metrical_frame import FIELDS, SEEN, WIDTH, field_of, read_frame
from mimeline.tracking.formats.metrical_rotations import (
    cameras_of,
    head_of,
    matrices_of,
    six_of,
    vectors_of,
)
from mimeline.tracking.formats.model_coefficients import rotations_of
from mimeline.tracking.formats.reprojection import reprojection_error
from mimeline.tracking.take import MOST_FRAMES, REPROJECTION, Origin, Take
from mimeline.vocabulary import HEAD

CHECKPOINT = "checkpoint"
NAME = re.compile(r"([0-9]{1,9})\.frame")
PIXELS, FOCUS = 512, 5000 / 512  # of a picture's side; in halves of it, as the tracker begins with

ENDINGS: tuple[str, ...] = ()
CONVENTION = Convention(
    title="metrical-tracker",
    files="a folder <name>, in it (or in checkpoint) 00000.frame, 00001.frame ...; beside them kpt "
    "and kpt_dense, the tracker's landmarks, where lost frames are to be known",
    coefficients="FLAME: flame.exp (1, 100), jaw (1, 6), eyes (1, 12: left, right), eyelids (1, 2: "
    "left, right; 0 at rest, 1 closed); the camera: camera.R (1, 6) and opencv.R (1, 3, 3); for "
    "a loss also flame.shape (1, 300), opencv.t (1, 3) and K (1, 3, 3). The rest is left alone",
    axes="of FLAME: +x to the subject's left, +y up, +z out of the face. opencv.R turns them into "
    "+x right, +y down, +z into the picture; camera.R into +x left, +y up, +z in",
    rotation="six numbers: the first two rows of the matrix. camera.R is for points as rows (p R), "
    "the transpose of opencv.R but for the axes; jaw and eyes are for points as columns (R p)",
    angle_unit="radians",
    sides="the subject's",
    first_frame=0,
    gap="no file; landmarks that are all 0 in kpt or kpt_dense",
    never="ARKit channels but the jaw's, lids' and gaze where the user's FLAME file is not given",
    evidence="the tracker's public code (FLAME.py, lbs.py, tracker.py) and PyTorch3D's "
    "(matrix_to_rotation_6d, opencv_from_cameras_projection); fixtures from geometry; no recording",
    meanings={
        "head_yaw_left": "the nose goes to +x of OpenCV's camera",
        "head_pitch_up": "the nose goes to -y of OpenCV's camera",
        "head_tilt_left": "the top of the head goes to +x of OpenCV's camera",
        "gaze_left": "the eyes' z goes to +x of FLAME",
        "gaze_up": "the eyes' z goes to +y of FLAME",
    },
)


def holds(path: Path) -> bool:
    """Whether a folder holds .frame files, by itself or in its checkpoint folder."""
    try:
        return any(
            NAME.fullmatch(file.name)
            for folder in (path / CHECKPOINT, path)
            if folder.is_dir()
            for file in folder.iterdir()
        )
    except OSError:
        return False


def read(path: Path, fps: str, face: Path | None, bad_values: str) -> Take:
    """Read the frames of a clip; a number without a file is a gap.

    fps: that the tracker worked at. face: the user's FLAME file, or None; with it and landmarks in
    kpt, these have a loss. bad_values: "fail" or "mask", of numbers that are none and of files that
    cannot be read.
    Raises BadFile, with the file, for what is no such frame, or where the cameras disagree.
    """
    files = _files(path)
    numbers = np.array(list(files))
    home = path.parent if path.name == CHECKPOINT else path
    landmarks, lost = landmarks_of(home, numbers, bad_values)
    fields = FIELDS if landmarks is None or face is None else FIELDS | SEEN
    told = np.full((len(files), WIDTH), np.nan)
    readable = np.ones(len(files), bool)
    failure = None
    for row, (number, file) in enumerate(files.items()):
        try:
            told[row] = read_frame(file, number, fields)
        except BadFile as error:
            if bad_values == "fail":
                raise
            failure, readable[row] = failure or error, False
    if not readable.any():
        raise failure
    head, source = head_of(
        field_of(told, "camera.R"),
        field_of(told, "opencv.R"),
        readable,
        list(files.values()),
        bad_values,
    )
    told[np.isnan(head).any(axis=(1, 2))] = np.nan  # nor is there a loss by a camera in doubt
    take = take_of(
        _rows(told, head),
        numbers,
        readable & ~lost,
        Fraction(fps),
        face,
        bad_values,
        path,
        first_frame=int(numbers[0]),
        numbered=True,
    )
    origins = dict(take.origins) | dict.fromkeys(HEAD, Origin(f"{source}, the head at rest"))
    take = replace(take, origins=origins)
    if landmarks is None:
        return take
    if face is None:
        take = replace(take, no_loss="landmarks are there: name ingest.metrical_tracker.face")
    else:
        take = _with_loss(take, told, numbers, landmarks, face)
    landmarks = landmarks.set_index(numbers).reindex(pd.RangeIndex(len(take.motion)))
    landmarks[~take.motion["valid"].to_numpy()] = np.nan
    return replace(take, coefficients=dict(take.coefficients) | {"landmarks": landmarks})


def write(
    folder: Path,
    flame: pd.DataFrame,
    head: np.ndarray,
    valid: np.ndarray | None = None,
) -> None:
    """`checkpoint/%05d.frame` in folder for every valid row, so that `read` gives the rows back.

    flame: the flame table's columns but the head's and neck's, complete; head (n, 3, 3): of the
    head against the camera, in the subject's frame; valid (n,) bool: no file where not.
    """
    n = len(flame)
    camera, opencv = cameras_of(head)
    joints = (flame[joint(name)] for name in ("jaw", "left_eye", "right_eye"))
    jaw, left, right = (six_of(rotations_of(vectors)) for vectors in joints)
    rows = {
        "flame": {
            "exp": flame[EXPRESSION].to_numpy(),
            "shape": np.zeros((n, 300)),
            "tex": np.zeros((n, 140)),
            "sh": np.zeros((n, 9, 3)),
            "eyes": np.concatenate([left, right], axis=1),
            "eyelids": flame[EYELIDS].to_numpy(),
            "jaw": jaw,
        },
        "camera": {
            "R": camera,
            "t": np.tile([0, 0, 1], (n, 1)),  # metres
            "fl": np.full((n, 1), FOCUS),
            "pp": np.zeros((n, 2)),
        },
        "opencv": {
            "R": opencv,
            "t": np.tile([0, 0, 1], (n, 1)),
            "K": np.tile(
                PIXELS / 2 * np.array([[FOCUS, 0, 1], [0, FOCUS, 1], [0, 0, 2 / PIXELS]]), (n, 1, 1)
            ),
        },
    }
    rows = {
        group: {name: values.astype(np.float32) for name, values in fields.items()}
        for group, fields in rows.items()
    }
    for row in range(n) if valid is None else np.flatnonzero(valid).tolist():
        frame = {
            group: {name: values[row : row + 1] for name, values in fields.items()}
            for group, fields in rows.items()
        }
        frame |= {
            "img_size": np.array([PIXELS, PIXELS]),
            "frame_id": f"{row:05d}",
            "global_step": row,
        }
        write_saved(folder / CHECKPOINT / f"{row:05d}.frame", frame)


def _files(path: Path) -> dict[int, Path]:
    """The .frame files of a take by number, in order."""
    folder = path / CHECKPOINT if (path / CHECKPOINT).is_dir() else path
    expected = "a folder of 00000.frame, 00001.frame ..., or of a folder checkpoint with them"
    try:
        names = sorted(file.name for file in folder.iterdir() if file.suffix == ".frame")
    except OSError as error:
        raise unreadable(
            path, error, expected=expected, remedy="Check data_dir and the folder in ingest."
        ) from error
    files: dict[int, Path] = {}
    for name in names:
        number = int(told[1]) if (told := NAME.fullmatch(name)) else MOST_FRAMES
        if number >= MOST_FRAMES or number in files:
            raise BadFile(
                folder / name,
                found="a number twice" if number in files else "a name that is no frame's number",
                expected=f"each number below {MOST_FRAMES} once",
                remedy="Name the files as the tracker does, 00000.frame and so on.",
            )
        files[number] = folder / name
    if not files:
        raise BadFile(
            path, found="no .frame file", expected=expected, remedy="Run the tracker on the clip."
        )
    return dict(sorted(files.items()))


def _with_loss(
    take: Take, told: np.ndarray, numbers: np.ndarray, landmarks: pd.DataFrame, face: Path
) -> Take:
    """The take with how far the landmarks lie from the head's, where the files tell enough."""
    errors = reprojection_error(
        face,
        field_of(told, "flame.shape"),
        field_of(told, "flame.exp"),
        matrices_of(field_of(told, "flame.jaw")),
        *(field_of(told, f"opencv.{name}") for name in ("R", "t", "K")),
        landmarks.to_numpy().reshape(-1, 2, 68).transpose(0, 2, 1),
    )
    if np.isnan(errors).all():
        return take
    losses = pd.Series(errors, numbers).reindex(take.motion["frame"]).to_numpy()
    return replace(take, motion=take.motion.assign(tracker_loss=losses), loss=REPROJECTION)


def _rows(told: np.ndarray, head: np.ndarray) -> pd.DataFrame:
    """Columns of the flame table that some frame tells."""
    jaw, eyes = field_of(told, "flame.jaw"), field_of(told, "flame.eyes")
    rows = {"head": vectors_of(head)}
    for name, six in {"jaw": jaw, "left_eye": eyes[:, :6], "right_eye": eyes[:, 6:]}.items():
        if not np.isnan(six).all():
            rows[name] = vectors_of(matrices_of(six))
    parts = [pd.DataFrame(vectors, columns=joint(name)) for name, vectors in rows.items()]
    parts.append(pd.DataFrame(field_of(told, "flame.exp"), columns=EXPRESSION))
    if not np.isnan(lids := field_of(told, "flame.eyelids")).all():
        parts.append(pd.DataFrame(lids, columns=EYELIDS))
    return pd.concat(parts, axis=1)
