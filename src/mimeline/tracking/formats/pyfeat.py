"""py-feat 2 tables: ARKit coefficients, head pose, gaze and landmarks, one row per face found."""

import logging
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

log = logging.getLogger(__name__)

NEEDED = ("frame", "FaceScore")
RECTANGLE = ("FaceRectX", "FaceRectY", "FaceRectWidth", "FaceRectHeight")
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
    """Read a table of one face: where others are beside it, it is followed from its surest row.

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
    rows, seen = _one_face(table, frame, score["FaceScore"].to_numpy(), path)
    table, frame, score = table.iloc[rows], frame[rows], score["FaceScore"].to_numpy()[rows]

    landmarks = [name for name in LANDMARKS if name in table]
    found = seen & (score > 0) & ~bad[rows]
    if "FaceRectX" in table:  # blank where no face was found, whatever else the row holds
        found &= numbers(table, ["FaceRectX"], path, "mask")[0].notna().to_numpy().ravel()
    values, bad_row = _numbers(table, columns, found, path, bad_values)
    points, bad_points = _numbers(table, landmarks, found, path, bad_values)
    found &= ~bad_row & ~bad_points
    radians = angles(
        values[[c for c in CONVENTION.signs if c in values]],
        "radians",
        path,
        "py-feat 2 writes radians; a table in degrees is read with ingest.format: table and "
        "ingest.table.angle_unit: degrees.",
    )
    turns, origins = by_channel(radians, CONVENTION.signs)
    channels = expressions(values, path).join(turns)
    found &= channels.notna().any(axis=1).to_numpy()
    score = np.where(seen, score, np.nan)
    motion = assemble(frame, found, channels, score, path)
    coefficients = {}
    if len(landmarks) == len(LANDMARKS):
        names = tables.COEFFICIENTS["landmarks"].value_names
        points = points.set_axis(names, axis=1).set_axis(frame)[found].astype("float32")
        coefficients["landmarks"] = points.reindex(pd.RangeIndex(len(motion)))
    return Take(
        motion,
        Fraction(fps) / stride,
        coefficients=coefficients,
        origins=all_origins(list(table), origins),
        first_frame=int(number.min()),
        numbered=True,
    )


def _numbers(
    table: pd.DataFrame, columns: list[str], found: np.ndarray, path: Path, bad_values: str
) -> tuple[pd.DataFrame, np.ndarray]:
    """Columns as floats, and which rows held something else.

    Where a face was found, found (n,), py-feat leaves all of these cells empty or none.
    """
    nothing = (table[columns].astype(str) == "").all(axis=1).to_numpy()
    blank_ok = (~found | nothing)[:, None]
    return numbers(table, columns, path, bad_values, blank_ok=blank_ok)


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


def _one_face(
    table: pd.DataFrame, frame: np.ndarray, score: np.ndarray, path: Path
) -> tuple[np.ndarray, np.ndarray]:
    """A row per frame (n_frames,), in the order of frames, and whether it holds the take's face.

    The take's face is the surest of all; before and after, in each frame, the one nearest to where
    it was seen last, unless that is more than its width away.
    Raises BadFile where a frame has several rows and no rectangle tells where they are.
    """
    score = np.nan_to_num(score, nan=-1.0)
    order = np.lexsort((-score, frame))
    starts = np.unique(frame[order], return_index=True)[1]
    rows = order[starts]
    if len(rows) == len(order):
        return rows, np.ones(len(rows), bool)
    if missing := [name for name in RECTANGLE if name not in table]:
        raise BadFile(
            path,
            place=f"column {missing[0]}",
            found="several rows of a frame, and no such column",
            expected=", ".join(RECTANGLE) + ", by which a face is followed",
            remedy="Keep one face to a table.",
        )
    x, y, width, height = numbers(table, list(RECTANGLE), path, "mask")[0].to_numpy().T
    centre = np.stack([x + width / 2, y + height / 2], axis=1)  # (n_rows, 2)
    there = (score > 0) & np.isfinite(centre).all(axis=1)
    groups = np.split(order, starts[1:])
    surest = int(np.argmax(np.where(there, score, -1)))
    start = int(np.searchsorted(frame[rows], frame[surest]))
    seen = np.zeros(len(rows), bool)
    for way in (range(start, len(rows)), range(start, -1, -1)):
        last = surest
        for at in way:
            faces = groups[at][there[groups[at]]]
            away = np.linalg.norm(centre[faces] - centre[last], axis=1)
            if len(faces) and away.min() <= width[last]:
                rows[at] = last = faces[away.argmin()]
                seen[at] = True
    log.warning(
        "%s: %d rows of other faces are left out", path, np.count_nonzero(there) - seen.sum()
    )
    return rows, seen


def _is_expression(name: str) -> bool:
    return canonical(name) in EXPRESSIONS
