"""OpenFace 2 CSV: action units, head pose, gaze and 68 landmarks, one row per frame and face.

The pose is R = Rx Ry Rz in the camera's axes (+X right in the picture, +Y down, +Z away), as
OpenFace's rotation helpers have it; a face at rest looks along -Z. Measured on a real table: of the
six orders and eight signs only this one, with all signs plus, turns the 68 landmarks of space back
onto one another with the line through the eyes along +X and the chin down (residue 0.29 mm; with a
sign turned 0.38 mm and more). The gaze is told in the same axes: eye 0, leftmost in the picture,
looks to the picture's right and eye 1 to its left, as eyes do that meet on the camera.

A take has no tracking loss. OpenFace puts its landmarks into space by back-projecting those of the
picture (GetShape: X = Z (x - cx) / fx), so that what they are off by when seen again is rounding,
6e-6 eye distances in that table, however lost the face: a rule on it would look applied and never
fire.
"""

import logging
from collections.abc import Collection, Sequence
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline.errors import BadFile
from mimeline.face.rotations import angles_of, turned
from mimeline.tables import COEFFICIENTS
from mimeline.tracking.convention import Convention
from mimeline.tracking.formats import action_units
from mimeline.tracking.formats.clip_tables import read_clips
from mimeline.tracking.formats.columns import angles, header_of, numbers, read_columns
from mimeline.tracking.formats.missing import blanked
from mimeline.tracking.take import MOST_FRAMES, Origin, Take, assemble
from mimeline.vocabulary import GAZE, HEAD

log = logging.getLogger(__name__)

NEEDED = ("frame", "confidence", "success")
POSE = ("pose_Rx", "pose_Ry", "pose_Rz")
EYES = tuple(tuple(f"gaze_{eye}_{axis}" for axis in "xyz") for eye in (0, 1))
GAZE_ANGLES = ("gaze_angle_x", "gaze_angle_y")
PICTURE = tuple(f"{axis}_{point}" for axis in "xy" for point in range(68))
UNITS = tuple(COEFFICIENTS["action_units"].value_names)
FROM_CAMERA = np.diag([1.0, -1.0, -1.0])  # camera's axes → subject's, and back

ENDINGS = (".csv",)
CONVENTION = Convention(
    title="OpenFace 2 CSV",
    files="<name>.csv",
    coefficients="17 action units of 0-5 and 18 of 0 or 1, by name (AU12_r, AU12_c); 68 landmarks",
    axes="the camera's: +X right in the picture, +Y down, +Z away",
    rotation="R = Rx Ry Rz of pose_Rx, pose_Ry, pose_Rz; gaze as vectors, else as two angles",
    angle_unit="radians",
    sides="action units have none; eye 0 is leftmost in the picture, the subject's right",
    first_frame=1,
    gap="success is 0; a number that is -nan(ind) is missing",
    never="which side of the face an action unit is on; tongue, cheeks, jaw to the sides; a loss: "
    "its landmarks in space are those of the picture, put into depth, and agree with them always",
    evidence="order and signs of the pose: a real table's landmarks in space, turned back by it; "
    "gaze: the same table, in which both eyes meet near the camera",
    meanings={
        "head_yaw_left": "-pose_Ry where the head does nothing else",
        "head_pitch_up": "-pose_Rx where the head does nothing else",
        "head_tilt_left": "+pose_Rz where the head does nothing else",
        "gaze_left": "mean of both eyes' vectors, turned back by the head's rotation: +x",
        "gaze_up": "mean of both eyes' vectors, turned back by the head's rotation: -y",
    },
)


def holds(path: Path) -> bool:
    """Whether the file's header is one of this format's."""
    return set(NEEDED) <= header_of(path)


def read(path: Path, bad_values: str, fps: str) -> Take:
    """Read a table of one face: of several face_id the one that is surest over all frames.

    bad_values: "fail" or "mask". fps: rate of the video that was analysed; the table's timestamps
    are not looked at, which are wrong where the video's rate varies.
    Frames count from 1, or from 0 in a table that has a frame 0. Raises BadFile or MissingColumn.
    """
    table = read_columns(path, needed=NEEDED)
    first_frame, table, success = _rows(table, path, bad_values)

    used = [c for c in (*POSE, *EYES[0], *EYES[1], *GAZE_ANGLES, *UNITS) if c in table]
    seen, bad = _numbers(table[success], used, path, bad_values)
    points, off = _numbers(table[success], [c for c in PICTURE if c in table], path, bad_values)
    intensities = [name for name in UNITS if name in seen and name.endswith("_r")]
    within, n_outside = action_units.clipped(seen[intensities], path)
    seen = seen.assign(**within)
    if n_outside:
        log.warning("%s: %d action-unit intensities outside of 0-5 are clipped", path, n_outside)

    channels, origins = action_units.channels(seen[intensities])
    turns = _turns(seen, path)
    for name, (values, origin) in {**_head(turns), **_gaze(turns, seen)}.items():
        origins[name] = origin
        if origin.measured:
            channels[name] = values
    valid = np.zeros(len(table), bool)
    valid[success] = ~bad & ~off & channels.notna().any(axis=1).to_numpy()

    index = table["frame"].to_numpy()
    channels = channels.reindex(table.index)
    motion = assemble(index, valid, channels, table["confidence"].to_numpy(float), path)
    clock = pd.RangeIndex(len(motion))
    good = valid[success]
    seen, points = (rows[good].set_axis(index[valid]) for rows in (seen, points))
    coefficients = _coefficients(seen, points, clock)
    return Take(
        motion,
        Fraction(fps),
        coefficients,
        origins,
        no_loss="OpenFace works its landmarks in space out from those in the picture",
        first_frame=first_frame,
        numbered=True,
    )


def read_head(path: Path) -> pd.DataFrame:
    """The head alone: frame, counted from 0, and its angles (radians, NaN where none was found).

    What is no number counts as none. Raises BadFile or MissingColumn.
    """
    return _head_of(read_columns(path, needed=(*NEEDED, *POSE)), path)


def read_heads(path: Path, clips: Collection[str] | None = None) -> pd.DataFrame:
    """As `read_head`, of a table of many clips, told apart by its column clip_id.

    clips: whose rows to read; None: all.
    """
    table = read_clips(path, (*NEEDED, *POSE), ("face_id",), clips)
    heads = [
        _head_of(rows, path).assign(clip_id=clip_id)
        for clip_id, rows in table.groupby("clip_id", sort=False)
    ]
    return pd.concat(heads) if heads else pd.DataFrame(columns=["clip_id", "frame", *HEAD])


def _head_of(table: pd.DataFrame, path: Path) -> pd.DataFrame:
    _, table, success = _rows(table, path, "mask")
    seen, _ = _numbers(table[success], POSE, path, "mask")
    yaw, pitch, tilt = angles_of(_turns(seen, path))
    found = pd.DataFrame(dict(zip(HEAD, (yaw, pitch, tilt), strict=True)), index=seen.index)
    return found.reindex(table.index).assign(frame=table["frame"]).reset_index(drop=True)


def _rows(table: pd.DataFrame, path: Path, bad_values: str) -> tuple[int, pd.DataFrame, np.ndarray]:
    """The first frame's number, a row per frame counted from 0, and where the face was found."""
    told, bad = numbers(table, ["frame", "success"], path, bad_values)
    table, told = table[~bad], told[~bad]  # a row that tells no frame is of no use: a gap
    if table.empty:
        raise BadFile(
            path, found="no row", expected="at least a frame", remedy="Run OpenFace again."
        )
    first_frame, frame = _frames(told["frame"], path)
    sure, _ = _numbers(table, ["confidence"], path, "mask")
    table = table.assign(frame=frame, success=told["success"], confidence=sure["confidence"])
    table = _one_face(table, path)
    success = table["success"].to_numpy(float) > 0
    return first_frame, table, success


def _frames(number: pd.Series, path: Path) -> tuple[int, np.ndarray]:
    """The first frame's number, and the frames counted from 0."""
    bad = (number < 0) | (number % 1 != 0)
    if bad.any():
        raise BadFile(
            path,
            place="column frame",
            found=f"{number[bad.idxmax()]:g}",
            expected="a whole number from 1 on",
            remedy="Run OpenFace again.",
        )
    first_frame = int(number.min())
    counted = number - min(first_frame, CONVENTION.first_frame)
    return first_frame, np.minimum(counted, MOST_FRAMES).to_numpy("int64")


def _one_face(table: pd.DataFrame, path: Path) -> pd.DataFrame:
    """A row per frame, in the order of frames; without success where the take's face is not in it.

    The take's face is the one whose confidence adds up to most where it was found.
    """
    keys = [name for name in ("frame", "face_id") if name in table]
    repeated = table.duplicated(keys)
    if repeated.any():
        raise BadFile(
            path,
            place="column frame",
            found=f"a frame twice, first in row {int(repeated.to_numpy().argmax()) + 1}",
            expected="each face of a frame once, faces told apart by face_id",
            remedy="Run OpenFace again, and keep one video to a table.",
        )
    face = table.get("face_id", pd.Series(0, table.index)).astype(str)
    if face.nunique() == 1:
        return table.sort_values("frame")
    sureness = table["confidence"].fillna(0).where(table["success"] > 0, 0)
    total = sureness.groupby(face).sum()
    log.warning("%s: %d other faces are left out", path, len(total) - 1)
    other = face != total.idxmax()
    table = table.assign(
        success=table["success"].mask(other, 0), confidence=table["confidence"].mask(other)
    )
    own_first = table.loc[other.sort_values(kind="stable").index]
    return own_first.drop_duplicates("frame").sort_values("frame")


def _numbers(
    table: pd.DataFrame, columns: Sequence[str], path: Path, bad_values: str
) -> tuple[pd.DataFrame, np.ndarray]:
    """Columns as floats, NaN where OpenFace says so, and which rows held something else.

    A cell is never empty, but in a column that is so throughout.
    """
    cells, missing = blanked(table[list(columns)])
    return numbers(cells, list(columns), path, bad_values, blank_ok=missing)


def _turns(seen: pd.DataFrame, path: Path) -> np.ndarray | None:
    """Rotations (n, 3, 3) of the head in the subject's frame; None where there is no pose."""
    if not set(POSE) <= set(seen):
        return None
    pose = seen[list(POSE)]
    radians = angles(pose, "radians", path, "Run OpenFace again: it writes radians.")
    x, y, z = radians.fillna(0).where(pose.notna()).to_numpy().T  # an angle may well stay 0
    # In the subject's frame, whose Y and Z point the other way, +Rx looks down, +Ry turns right and
    # +Rz tilts left; their order stays.
    rest = np.zeros(len(pose))
    return turned(rest, -x, rest) @ turned(-y, rest, rest) @ turned(rest, rest, z)


def _head(turns: np.ndarray | None) -> dict[str, tuple]:
    if turns is None:
        return dict.fromkeys(HEAD, (None, Origin("the table has no pose", measured=False)))
    origin = Origin("rotation pose_Rx, pose_Ry, pose_Rz")
    return {name: (v, origin) for name, v in zip(HEAD, angles_of(turns), strict=True)}


def _gaze(turns: np.ndarray | None, seen: pd.DataFrame) -> dict[str, tuple]:
    """gaze_left and gaze_up in the head, from a direction that is told against the camera."""
    if {*EYES[0], *EYES[1]} <= set(seen):
        source, ahead = "gaze_0 and gaze_1", sum(seen[list(eye)].to_numpy() for eye in EYES)
    elif set(GAZE_ANGLES) <= set(seen):
        x, y = np.tan(seen[list(GAZE_ANGLES)].to_numpy()).T
        source, ahead = "gaze_angle", np.stack([x, y, np.full_like(x, -1)], axis=1)
    else:
        return dict.fromkeys(GAZE, (None, Origin("the table has no gaze", measured=False)))
    if turns is None:
        origin = Origin("without a pose the gaze is not known in the head", measured=False)
        return dict.fromkeys(GAZE, (None, origin))
    length = np.linalg.norm(ahead, axis=1, keepdims=True)
    ahead = np.divide(ahead, length, out=np.full_like(ahead, np.nan), where=length > 0)  # (n, 3)
    in_head = np.einsum("nji,nj->ni", turns, ahead @ FROM_CAMERA)  # (n, 3): R transposed
    left, up = np.arctan2(in_head[:, 0], in_head[:, 2]), np.arcsin(np.clip(in_head[:, 1], -1, 1))
    origin = Origin(f"{source}, mean of both eyes, turned back by the head's pose")
    return {"gaze_left": (left, origin), "gaze_up": (up, origin)}


def _coefficients(
    seen: pd.DataFrame, points: pd.DataFrame, clock: pd.RangeIndex
) -> dict[str, pd.DataFrame]:
    """Action units and landmarks as the tables beside the motion have them, where there are any."""
    flat = points.rename(columns={old: f"{old[0]}_{int(old[2:]):02d}" for old in PICTURE})
    return {
        name: rows.reindex(index=clock, columns=COEFFICIENTS[name].value_names)
        for name, rows in (("action_units", seen), ("landmarks", flat))
        if rows.columns.isin(COEFFICIENTS[name].schema.names).any()
    }
