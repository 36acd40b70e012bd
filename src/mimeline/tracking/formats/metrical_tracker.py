"""metrical-tracker: a folder of .frame files per clip (Zielonka et al. 2022).

A .frame is what torch.save makes of NumPy arrays: FLAME's coefficients, and the camera twice, in
PyTorch3D's axes and in OpenCV's. FLAME's own head stays at rest; the camera goes round it, and so
tells the head's pose. A rotation of six numbers is the first two rows of its matrix.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from mimeline.archives.torch_saved import read_saved, write_saved
from mimeline.errors import BadFile, unreadable
from mimeline.tracking.convention import Convention
from mimeline.tracking.formats.flame_take import EXPRESSION, joint, rotations_of, take_of
from mimeline.tracking.formats.kpt import landmarks_of
from mimeline.tracking.formats.reprojection import reprojection_error
from mimeline.tracking.loss import REPROJECTION
from mimeline.tracking.take import MOST_FRAMES, Origin, Take
from mimeline.vocabulary import HEAD

CHECKPOINT = "checkpoint"
NAME = re.compile(r"([0-9]{1,9})\.frame")
EYELIDS = ["eyelid_left", "eyelid_right"]
OPENCV_FROM_FLAME = np.diag([1.0, -1.0, -1.0])  # for a face that looks into the camera
OPENCV_FROM_PYTORCH3D = np.diag([-1.0, -1.0, 1.0])
TOLERANCE = 1e-2  # of a rotation's entries, between the two cameras and from being a rotation
PIXELS, FOCUS = 512, 5000 / 512  # of a picture's side; in halves of it, as the tracker begins with

# What a frame tells → its shape, but for the leading 1; and what only its landmarks are held to.
FIELDS: dict[str, tuple[int, ...]] = {
    "flame.exp": (len(EXPRESSION),),
    "flame.jaw": (6,),
    "flame.eyes": (12,),
    "flame.eyelids": (2,),
    "camera.R": (6,),
    "opencv.R": (3, 3),
}
SEEN = {"flame.shape": (300,), "opencv.t": (3,), "opencv.K": (3, 3)}
FEWER = ("flame.exp", "flame.shape")  # a tracker may have less of them: the others rest
ENDS = np.cumsum([math.prod(shape) for shape in (FIELDS | SEEN).values()])
PLACES = {
    name: slice(end - math.prod(shape), end)
    for (name, shape), end in zip((FIELDS | SEEN).items(), ENDS, strict=True)
}
REMEDY = (
    "Let the tracker make the frame anew (delete it and those after it, and start it again), or "
    "set ingest.bad_values: mask to treat it as a gap."
)

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
    told = np.full((len(files), PLACES[list(fields)[-1]].stop), np.nan)
    readable = np.ones(len(files), bool)
    failure = None
    for row, (number, file) in enumerate(files.items()):
        try:
            _take_over(told[row], read_saved(file, REMEDY), number, file, fields)
        except BadFile as error:
            if bad_values == "fail":
                raise
            failure, readable[row] = failure or error, False
    if not readable.any():
        raise failure
    head, source = _heads(told, readable, list(files.values()), bad_values)
    take = take_of(
        _rows(told, head),
        numbers,
        readable & ~lost,
        Fraction(fps),
        face,
        bad_values,
        path,
        first_frame=int(numbers[0]),
    )
    origins = dict(take.origins) | dict.fromkeys(HEAD, Origin(f"{source}, the head at rest"))
    take = replace(take, origins=origins)
    if landmarks is None:
        return take
    if fields is not FIELDS:
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
    opencv = OPENCV_FROM_FLAME @ np.asarray(head, np.float64)  # (n, 3, 3)
    pytorch3d = (OPENCV_FROM_PYTORCH3D @ opencv).transpose(0, 2, 1)
    joints = (flame[joint(name)] for name in ("jaw", "left_eye", "right_eye"))
    jaw, left, right = (_six(rotations_of(vectors)) for vectors in joints)
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
            "R": _six(pytorch3d),
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


def _take_over(
    told: np.ndarray,
    content: Mapping,
    number: int,
    file: Path,
    fields: Mapping[str, tuple[int, ...]],
) -> None:
    """Fill told, a row of PLACES, with the fields of a frame; NaN is left where it lacks one."""
    frame_id = content.get("frame_id", number)
    if str(frame_id)[:20].lstrip("0") != str(number).lstrip("0"):
        raise BadFile(
            file,
            place="frame_id",
            found=repr(str(frame_id)[:20]),
            expected=f"{number:05d}, as the file's name says",
            remedy="Give the file its own name back. Frames count from 0; the pictures beside "
            "them from 1, and from begin_frames on where the tracker skipped some.",
        )
    for name, shape in fields.items():
        group, _, field = name.partition(".")
        values = content[group].get(field) if isinstance(content.get(group), dict) else None
        if values is None and name != "flame.exp":
            continue
        if not isinstance(values, np.ndarray) or values.dtype.kind not in "fiu":
            _refuse(file, name, "nothing" if values is None else "no numbers", shape)
        found = values.shape[1:] if values.ndim > len(shape) else values.shape
        fewer = name in FEWER and len(found) == 1 and 0 < found[0] < shape[0]
        if values.size != math.prod(found) or (found != shape and not fewer):
            _refuse(file, name, str(values.shape), shape)
        if not np.isfinite(values).all():
            _refuse(file, name, "a NaN or infinity", shape)
        told[PLACES[name]] = 0
        told[PLACES[name]][: values.size] = values.ravel()


def _refuse(file: Path, name: str, found: str, shape: tuple[int, ...]) -> None:
    expected = f"numbers of shape {(1, *shape)}"
    raise BadFile(file, place=name, found=found, expected=expected, remedy=REMEDY)


def _heads(
    told: np.ndarray, readable: np.ndarray, files: list[Path], bad_values: str
) -> tuple[np.ndarray, str]:
    """Rotations (n, 3, 3) of the head in the subject's frame, NaN where unknown; and their source.

    Raises BadFile where a frame has no camera, or its two cameras differ.
    """
    opencv = told[:, PLACES["opencv.R"]].reshape(-1, 3, 3)
    other = OPENCV_FROM_PYTORCH3D @ _matrices(told[:, PLACES["camera.R"]]).transpose(0, 2, 1)
    apart = np.abs(opencv - other).max(axis=(1, 2)) > TOLERANCE  # not where one is missing
    if (apart & readable).any():
        raise BadFile(
            files[(apart & readable).argmax()],
            place="camera.R",
            found="another rotation than in opencv.R",
            expected="the same camera: the first two rows of PyTorch3D's matrix, +x left, +y up, "
            "+z in",
            remedy="Write camera.R as PyTorch3D's matrix_to_rotation_6d does, or leave one away.",
        )
    source = "camera.R" if np.isnan(opencv[readable]).all() else "opencv.R"
    camera = other if source == "camera.R" else opencv
    bad = readable & ~_are_rotations(camera)
    if bad.any() and (bad_values == "fail" or bad.sum() == readable.sum()):
        raise BadFile(
            files[bad.argmax()],
            place=source,
            found="no rotation",
            expected="opencv.R of shape (1, 3, 3) or camera.R of shape (1, 6), a rotation",
            remedy=REMEDY,
        )
    camera[bad] = np.nan
    return OPENCV_FROM_FLAME @ camera, source


def _are_rotations(matrices: np.ndarray) -> np.ndarray:
    """Which (n,) of matrices (n, 3, 3) turn and do nothing else; NaN does not."""
    with np.errstate(invalid="ignore", over="ignore"):
        off = np.abs(matrices @ matrices.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
        return (off < TOLERANCE) & (np.linalg.det(matrices) > 0)


def _with_loss(
    take: Take, told: np.ndarray, numbers: np.ndarray, landmarks: pd.DataFrame, face: Path
) -> Take:
    """The take with how far the landmarks lie from the head's, where the files tell enough."""

    def of(name: str) -> np.ndarray:
        return told[:, PLACES[name]].reshape(len(told), *(FIELDS | SEEN)[name])

    errors = reprojection_error(
        face,
        of("flame.shape"),
        of("flame.exp"),
        _matrices(of("flame.jaw")),
        *(of(f"opencv.{name}") for name in ("R", "t", "K")),
        landmarks.to_numpy().reshape(-1, 2, 68).transpose(0, 2, 1),
    )
    if np.isnan(errors).all():
        return take
    losses = pd.Series(errors, numbers).reindex(take.motion["frame"]).to_numpy()
    return replace(take, motion=take.motion.assign(tracker_loss=losses), loss=REPROJECTION)


def _rows(told: np.ndarray, head: np.ndarray) -> pd.DataFrame:
    """Columns of the flame table that some frame tells."""
    rows = {"head": _vectors(head)}
    if not np.isnan(told[:, PLACES["flame.jaw"]]).all():
        rows["jaw"] = _vectors(_matrices(told[:, PLACES["flame.jaw"]]))
    if not np.isnan(eyes := told[:, PLACES["flame.eyes"]]).all():
        rows["left_eye"], rows["right_eye"] = (
            _vectors(_matrices(eyes[:, half])) for half in (slice(6), slice(6, 12))
        )
    parts = [pd.DataFrame(values, columns=joint(name)) for name, values in rows.items()]
    parts.append(pd.DataFrame(told[:, PLACES["flame.exp"]], columns=EXPRESSION))
    if not np.isnan(lids := told[:, PLACES["flame.eyelids"]]).all():
        parts.append(pd.DataFrame(lids, columns=EYELIDS))
    return pd.concat(parts, axis=1)


def _matrices(six: np.ndarray) -> np.ndarray:
    """Matrices (n, 3, 3) of rotations (n, 6); NaN where the six numbers tell none.

    The rows are made orthonormal one after the other (Zhou et al. 2019, section B).
    """
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        first = six[:, :3] / np.linalg.norm(six[:, :3], axis=1, keepdims=True)
        second = six[:, 3:] - (first * six[:, 3:]).sum(axis=1, keepdims=True) * first
        second /= np.linalg.norm(second, axis=1, keepdims=True)
        return np.stack([first, second, np.cross(first, second)], axis=1)


def _six(matrices: np.ndarray) -> np.ndarray:
    """The first two rows (n, 6) of matrices (n, 3, 3)."""
    return matrices[:, :2].reshape(-1, 6)


def _vectors(matrices: np.ndarray) -> np.ndarray:
    """Axis times angle (n, 3) of rotations (n, 3, 3); NaN where they are."""
    known = np.isfinite(matrices).all(axis=(1, 2))
    vectors = np.full((len(matrices), 3), np.nan)
    if known.any():
        vectors[known] = Rotation.from_matrix(matrices[known]).as_rotvec()
    return vectors
