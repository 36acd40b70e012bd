"""py-feat 2 tables: ARKit coefficients, head pose, gaze and landmarks, one row per face found."""

from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.errors import BadFile, MissingColumn
from mimeline.tracking.convention import Convention
from mimeline.tracking.formats.columns import (
    all_origins,
    angles,
    by_channel,
    expressions,
    header_of,
    line_of,
    numbers,
    read_columns,
)
from mimeline.tracking.take import MOST_FRAMES, Take, assemble
from mimeline.vocabulary import EXPRESSIONS, canonical

NEEDED = ("frame", "FaceScore")
LANDMARKS = tuple(f"{axis}_{point}" for axis in "xy" for point in range(68))

ENDINGS = (".csv",)
CONVENTION = Convention(
    title="py-feat 2 table",
    files="<name>.csv",
    coefficients="51 ARKit coefficients in [0, 1] and _neutral, camelCase, found by name; 68 "
    "landmarks x_0 ... y_67 in pixels",
    axes="of the picture: yaw, pitch and roll are positive toward the subject's right, down and "
    "toward the right shoulder",
    rotation="three angles of the head against the camera, and two of the gaze in the head",
    angle_unit="radians",
    sides="the subject's",
    first_frame=0,
    gap="a row whose FaceScore is 0 or empty or whose FaceRectX is empty, or no row; where only "
    "every n-th frame was analysed (ingest.pyfeat.stride) the clock runs at that rate",
    never="tongueOut; its action units are probabilities, not intensities, and are not taken",
    evidence="on the tables that py-feat publishes: the head's angles against the rotation of its "
    "own 478 mesh points (|r| > .93); the gaze against the eyeLook coefficients (r = .55 and .42), "
    "and it does not follow the head (slope -.2 and -.3 on the head's angles, where a gaze against "
    "the camera would have 1).",
    signs={
        "Yaw": ("head_yaw_left", -1.0),
        "Pitch": ("head_pitch_up", -1.0),
        "Roll": ("head_tilt_left", -1.0),
        "gaze_yaw": ("gaze_left", 1.0),
        "gaze_pitch": ("gaze_up", 1.0),
    },
)


def holds(path: Path) -> bool:
    """Whether the file's header is one of this format's."""
    names = header_of(path)
    return names.issuperset(NEEDED) and any(_is_expression(name) for name in names)


def read(path: Path, fps: str, stride: int, bad_values: str) -> Take:
    """Read a table; where a frame holds several faces the surest one is taken.

    fps: rate of the video that was analysed. stride: every n-th of its frames was; frame 0 is the
    first of the clock. bad_values: "fail" or "mask".
    Raises BadFile or MissingColumn with line and column.
    """
    table = read_columns(path, needed=NEEDED)
    columns = [name for name in table if name in CONVENTION.signs or _is_expression(name)]
    if not any(_is_expression(name) for name in columns):
        raise MissingColumn(
            path,
            place="line 1",
            found="no column of a blend shape",
            expected="columns as jawOpen",
            remedy="Run a detector of py-feat 2 that gives blend shapes.",
        )
    number, bad = numbers(table, ["frame"], path, bad_values)
    table, number = table[~bad], number.loc[~bad, "frame"]  # else its frame is a gap
    if table.empty:
        raise BadFile(
            path, found="no row", expected="at least a frame", remedy="Run py-feat again."
        )
    frame = _frames(number, stride, path)
    score, bad = numbers(table, ["FaceScore"], path, bad_values, blank_ok=True)
    surest = _surest(frame, score["FaceScore"].to_numpy())
    table, frame, score = table.iloc[surest], frame[surest], score["FaceScore"].to_numpy()[surest]

    landmarks = [name for name in LANDMARKS if name in table]
    values, bad_row = numbers(table, columns, path, bad_values, blank_ok=True)
    points, bad_points = numbers(table, landmarks, path, bad_values, blank_ok=True)
    found = (score > 0) & ~bad[surest] & ~bad_row & ~bad_points
    if "FaceRectX" in table:  # blank where no face was found, whatever else the row holds
        found &= numbers(table, ["FaceRectX"], path, "mask")[0].notna().to_numpy().ravel()
    radians = angles(
        values[[c for c in CONVENTION.signs if c in values]], "radians", path, "Run py-feat again."
    )
    turns, origins = by_channel(radians, CONVENTION.signs)
    motion = assemble(frame, found, expressions(values, path).join(turns), score, path)
    coefficients = {}
    if len(landmarks) == len(LANDMARKS):
        names = tables.COEFFICIENTS["landmarks"].schema.names[2:]
        points = points.set_axis(names, axis=1).set_axis(frame)[found].astype("float32")
        coefficients["landmarks"] = points.reindex(pd.RangeIndex(len(motion)))
    return Take(
        motion,
        Fraction(fps) / stride,
        coefficients=coefficients,
        origins=all_origins(columns, origins),
        first_frame=int(number.min()),
    )


def _frames(number: pd.Series, stride: int, path: Path) -> np.ndarray:
    """Frame numbers of the clock that counts every stride-th frame of the video."""
    bad = ((number < 0) | (number % stride != 0)).to_numpy()
    if bad.any():
        row = int(np.argmax(bad))
        raise BadFile(
            path,
            place=f"line {line_of(path, number.index[row])}, column frame",
            found=f"{number.iloc[row]:g}",
            expected=f"a multiple of {stride}" if stride > 1 else "a whole number from 0 on",
            remedy="Set ingest.pyfeat.stride to n where every n-th frame was analysed.",
        )
    return np.minimum(number // stride, MOST_FRAMES).to_numpy("int64")


def _surest(frame: np.ndarray, score: np.ndarray) -> np.ndarray:
    """Rows of the face with the best score of each frame, in the order of frames."""
    order = np.lexsort((-np.nan_to_num(score, nan=-1.0), frame))
    return order[np.unique(frame[order], return_index=True)[1]]


def _is_expression(name: str) -> bool:
    return canonical(name) in EXPRESSIONS
