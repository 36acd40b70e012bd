"""Sequences of FLAME's coefficients in an npz file, under the names that people give them.

What a name means is told by its width alone where it means several things; one coefficient under
two names is refused. flame_take has the axes and the order of the joints.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline.archives import npz
from mimeline.atomic import whole
from mimeline.errors import BadFile, MimelineError
from mimeline.tracking.convention import Convention
from mimeline.tracking.formats.flame_take import EXPRESSION, EYELIDS, joint, take_of
from mimeline.tracking.take import MOST_FRAMES, Take

ROOT, NECK, JAW = joint("head"), joint("neck"), joint("jaw")
LEFT_EYE, RIGHT_EYE = joint("left_eye"), joint("right_eye")

# What arrays are called → the columns that one holds, by its width; 0: any width up to these.
GROUPS: tuple[tuple[tuple[str, ...], dict[int, list[str]]], ...] = (
    (("expression", "expression_params", "expr", "exp", "expcode"), {0: EXPRESSION}),
    (("global_orient", "global_pose", "global_rotation", "rotation"), {3: ROOT}),
    (
        ("pose", "pose_params", "posecode"),
        {3: ROOT, 6: [*ROOT, *JAW], 15: [*ROOT, *NECK, *JAW, *LEFT_EYE, *RIGHT_EYE]},
    ),
    (("neck_pose", "neck"), {3: NECK}),
    (("jaw_pose", "jaw"), {3: JAW}),
    (("eyes_pose", "eye_pose", "eyes"), {6: [*LEFT_EYE, *RIGHT_EYE]}),
    (("leye_pose", "left_eye_pose"), {3: LEFT_EYE}),
    (("reye_pose", "right_eye_pose"), {3: RIGHT_EYE}),
    (("eyelids", "eyelid_params"), {2: EYELIDS}),
    (("mmhead",), {56: [*EXPRESSION[:50], *NECK, *JAW]}),
)
LAYOUTS = {name: layouts for names, layouts in GROUPS for name in names}
WRITTEN = {
    "expression": EXPRESSION,
    "global_orient": ROOT,
    "neck_pose": NECK,
    "jaw_pose": JAW,
    "leye_pose": LEFT_EYE,
    "reye_pose": RIGHT_EYE,
    "eyelids": EYELIDS,
}
FRAME, VALID, RATE = ("frame", "frames"), ("valid",), ("fps", "mocap_frame_rate")
KNOWN = frozenset((*LAYOUTS, *FRAME, *VALID, *RATE))
NAMED = 8  # of the arrays that are left alone
MOST_BYTES = 500_000_000  # of a take's arrays: a million frames of 100 singles

REMEDY = "docs/mapping.md lists the names and shapes; write the arrays with numpy.savez."

ENDINGS = (".npz",)
CONVENTION = Convention(
    title="Sequences of FLAME coefficients",
    files="<name>.npz with an array per coefficient, a row per frame",
    coefficients="up to 100 expressions (expression, expr, exp or expcode), root (global_orient, "
    "global_pose or rotation), neck_pose, jaw_pose, eyes_pose or leye_pose and reye_pose, eyelids; "
    "pose of 3 (root), 6 (root, jaw) or 15 (all joints); mmhead of 56 (50 expressions, neck, jaw). "
    "Identity, translation and what else is there are left alone",
    axes="the subject's: +x to the subject's left, +y up, +z out of the face; with the camera's y "
    "down and z away a face is turned by pi about x, which is seen and turned back",
    rotation="axis times angle; head = root, then neck",
    angle_unit="radians",
    sides="the subject's",
    first_frame=None,
    gap="a number that frame leaves out; 0 in valid",
    never="ARKit channels but the jaw's, lids' and gaze where the user's FLAME file is not given",
    evidence="derived from FLAME's published axes and its chain of joints; no recording",
    meanings={
        "head_yaw_left": "+y of root and neck, where the other two are 0",
        "head_pitch_up": "-x of root and neck, where the other two are 0",
        "head_tilt_left": "-z of root and neck, where the other two are 0",
    },
)


def holds(path: Path) -> bool:
    """Whether an npz file has an array of one of the names."""
    try:
        if path.suffix.lower() not in ENDINGS or not path.is_file():
            return False
        return any(name in LAYOUTS for name in npz.array_names(path, REMEDY))
    except (OSError, MimelineError):
        return False


def read(path: Path, fps: str, face: Path | None, bad_values: str) -> Take:
    """Read a sequence, a row per frame; arrays of other names are left alone, and it is told.

    fps: frames per second; a file that tells its own must agree. face: the user's FLAME file, or
    None. bad_values: "fail" or "mask", of numbers that are none.
    Raises BadFile for what is no such sequence.
    """
    names = npz.array_names(path, REMEDY)
    arrays = npz.read_arrays(path, REMEDY, KNOWN, MOST_BYTES)
    others = sorted(set(names) - KNOWN)
    rows = _rows(arrays, others, path)
    _agree(_one(arrays, RATE, path), Fraction(fps), path)
    told = _one(arrays, FRAME, path)
    frame = _frames(told, len(rows), path)
    valid = _flags(_one(arrays, VALID, path), len(rows), path)
    take = take_of(
        rows, frame, valid, Fraction(fps), face, bad_values, path, numbered=told is not None
    )
    return _with_others(take, others)


def write(path: Path, take: Take) -> None:
    """The FLAME coefficients of a take, so that `read` gives the take back.

    Joints and eyelids that the take does not tell are left out, as are the last expressions.
    """
    rows = take.coefficients["flame"]
    arrays = {}
    for name, columns in WRITTEN.items():
        told = np.flatnonzero(rows[columns].notna().any())
        if len(told):
            arrays[name] = rows[columns[: told[-1] + 1]].fillna(0).to_numpy(np.float32)
    valid = take.motion["valid"].to_numpy(bool)
    with whole(path) as part, open(part, "wb") as file:
        np.savez_compressed(file, **arrays, valid=valid, fps=float(take.fps))


def _with_others(take: Take, others: Sequence[str]) -> Take:
    """The take, where what it does not tell names the arrays that were left alone."""
    if not others:
        return take
    listed = ", ".join(name[:40] for name in others[:NAMED])
    beside = f"; left alone: {listed}" + (" and more" if len(others) > NAMED else "")
    origins = {
        name: origin if origin.measured else replace(origin, text=origin.text + beside)
        for name, origin in take.origins.items()
    }
    return replace(take, origins=origins)


def _rows(arrays: Mapping[str, np.ndarray], others: Sequence[str], path: Path) -> pd.DataFrame:
    """The coefficients (n, any) that a file's arrays tell. others: names that mean nothing here."""
    found: dict[str, tuple[str, np.ndarray]] = {}  # column → name of its array, numbers
    count = None
    for name, array in arrays.items():
        if name not in LAYOUTS:
            continue
        columns = _columns(name, array, path)
        if array.dtype.kind not in "fiu":
            raise BadFile(
                path,
                place=f"array {name}",
                found=f"type {array.dtype}",
                expected="numbers",
                remedy=REMEDY,
            )
        count = len(array) if count is None else count
        if not 0 < len(array) <= MOST_FRAMES or len(array) != count:
            raise BadFile(
                path,
                place=f"array {name}",
                found=f"{len(array)} rows",
                expected=f"as many rows as other arrays, from 1 to {MOST_FRAMES}",
                remedy=REMEDY,
            )
        for column, numbers in zip(columns, array.T, strict=False):
            if column in found:
                raise BadFile(
                    path,
                    place=f"arrays {found[column][0]} and {name}",
                    found=f"{column} in both",
                    expected="each coefficient once",
                    remedy="Leave one of them out.",
                )
            found[column] = name, numbers
    if count is None:
        raise BadFile(
            path,
            found=f"arrays {', '.join(sorted([*arrays, *others])[:8]) or 'of no name'}",
            expected="an array named expression, pose, jaw_pose or the like",
            remedy=REMEDY,
        )
    return pd.DataFrame({column: np.float64(numbers) for column, (_, numbers) in found.items()})


def _columns(name: str, array: np.ndarray, path: Path) -> list[str]:
    """The columns that an array of this name and width holds."""
    layouts = LAYOUTS[name]
    width = array.shape[1] if array.ndim == 2 else 0
    if width in layouts and width:
        return layouts[width]
    if 0 in layouts and 0 < width <= len(layouts[0]):
        return layouts[0][:width]
    widths = " or ".join(str(w) if w else f"up to {len(layouts[0])}" for w in layouts)
    raise BadFile(
        path,
        place=f"array {name}",
        found=f"shape {array.shape}",
        expected=f"(frames, {widths})",
        remedy=REMEDY,
    )


def _one(arrays: Mapping[str, np.ndarray], names: tuple[str, ...], path: Path) -> np.ndarray | None:
    """The array of one of these names, as finite numbers, or None."""
    there = [name for name in names if name in arrays]
    if len(there) > 1:
        raise BadFile(
            path,
            place=f"arrays {' and '.join(there)}",
            found="both",
            expected="one of them",
            remedy="Leave one of them out.",
        )
    if not there:
        return None
    array = arrays[there[0]]
    if array.dtype.kind not in "fiub" or not np.isfinite(array).all():
        raise BadFile(
            path,
            place=f"array {there[0]}",
            found=f"type {array.dtype}, or NaN",
            expected="numbers",
            remedy=REMEDY,
        )
    return array


def _agree(told: np.ndarray | None, fps: Fraction, path: Path) -> None:
    if told is not None and (told.size != 1 or not abs(told.item() / float(fps) - 1) < 1e-4):
        raise BadFile(
            path,
            place=f"array {' or '.join(RATE)}",
            found=f"{told.item():g}" if told.size == 1 else f"shape {told.shape}",
            expected=f"{float(fps):g} frames per second, as the configuration has it",
            remedy="Correct ingest.flame.fps.",
        )


def _frames(told: np.ndarray | None, count: int, path: Path) -> np.ndarray:
    """Frame numbers (count,) from 0 on: by row where the file tells none."""
    if told is None:
        return np.arange(count)
    fits = told.shape == (count,) and (told == np.floor(told)).all()
    if not fits or told[0] < 0 or told[-1] >= MOST_FRAMES or (np.diff(np.float64(told)) <= 0).any():
        raise BadFile(
            path,
            place="array frame",
            found="numbers that do not rise by whole steps, or not one a row",
            expected=f"rising whole numbers from 0 to {MOST_FRAMES - 1}, one for each row",
            remedy="Mend the numbers, or leave the array out where no frame is missing.",
        )
    return told.astype("int64")


def _flags(told: np.ndarray | None, count: int, path: Path) -> np.ndarray:
    if told is None:
        return np.ones(count, bool)
    if told.shape != (count,):
        raise BadFile(
            path,
            place="array valid",
            found=f"shape {told.shape}",
            expected=f"({count},)",
            remedy=REMEDY,
        )
    return told.astype(bool)
