"""py-feat 2 tables: ARKit coefficients but tongueOut, head pose and gaze, one row per face found.

Signs, measured on real tables: Yaw, Roll and Pitch against the rotation of the 478 mesh points
(|r| > .93; positive is toward the subject's right, the subject's right shoulder and down), the gaze
against the eyeLook coefficients (r = .55 and .42; positive is to the subject's left and up). All
are radians. Where only every n-th frame was analysed the clock runs at that rate.
"""

from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline.errors import BadFile
from mimeline.tracking.columns import angles, expressions, numbers, read_columns
from mimeline.tracking.convention import Convention
from mimeline.tracking.take import MOST_FRAMES, Take, assemble
from mimeline.vocabulary import EXPRESSIONS, canonical

SIGNS = {
    "Yaw": ("head_yaw_left", -1.0),
    "Pitch": ("head_pitch_up", -1.0),
    "Roll": ("head_tilt_left", -1.0),
    "gaze_yaw": ("gaze_left", 1.0),
    "gaze_pitch": ("gaze_up", 1.0),
}

ENDINGS = (".csv",)
CONVENTION = Convention(
    title="py-feat 2 table",
    files="<name>.csv",
    coefficients="",
    axes="",
    rotation="",
    angle_unit="radians",
    sides="the subject's",
    first_frame=None,
    gap="",
    never="",
    evidence="",
)


def holds(path: Path) -> bool:
    """Whether the file's header is one of this format's."""
    try:
        with open(path, encoding="utf-8-sig") as file:
            return "FaceScore" in file.readline(100_000)
    except (OSError, ValueError):
        return False


def read(path: Path, fps: str, stride: int, bad_values: str) -> Take:
    """Read a table; where a frame holds several faces the surest one is taken.

    fps: rate of the video that was analysed. stride: every n-th of its frames was; frame 0 is the
    first of the clock. bad_values: "fail" or "mask".
    Raises BadFile or MissingColumn with line and column.
    """
    table = read_columns(path, text=("frame", "FaceScore"))
    number, bad = numbers(table, ["frame"], path, bad_values)
    table = table[~bad]  # a row that tells no frame is of no use; its frame is a gap
    if table.empty:
        raise BadFile(
            path, found="no row", expected="at least a frame", remedy="Run py-feat again."
        )
    index = _frames(number.loc[~bad, "frame"], stride, path)
    score, _ = numbers(table, ["FaceScore"], path, bad_values, blank_ok=True)
    table = table.assign(frame=index, FaceScore=score["FaceScore"])
    table = table.sort_values("FaceScore", ascending=False, kind="stable", na_position="last")
    table = table.drop_duplicates("frame").sort_values("frame")
    frame = table["frame"].to_numpy()
    columns = [name for name in table if name in SIGNS or _is_expression(name)]
    values, bad = numbers(table, columns, path, bad_values, blank_ok=True)
    values = values.reset_index(drop=True)
    channels = expressions(values, path)
    radians = angles(
        values[[c for c in SIGNS if c in values]], "radians", path, "Run py-feat again."
    )
    for column in radians:
        name, sign = SIGNS[column]
        channels[name] = sign * radians[column]
    found = table["FaceScore"].notna().to_numpy() & ~bad
    motion = assemble(frame, found, channels, table["FaceScore"].to_numpy(float), path)
    return Take(motion, Fraction(fps) / stride)


def _frames(number: pd.Series, stride: int, path: Path) -> np.ndarray:
    """Frame numbers of the clock that counts every stride-th frame of the video."""
    bad = (number < 0) | (number % stride != 0)
    if bad.any():
        raise BadFile(
            path,
            place=f"line {bad.idxmax() + 2}, column frame",
            found=f"{number[bad.idxmax()]:g}",
            expected=f"a multiple of {stride}" if stride > 1 else "a whole number from 0 on",
            remedy="Set ingest.pyfeat.stride to n where every n-th frame was analysed.",
        )
    return np.minimum(number // stride, MOST_FRAMES).to_numpy("int64")


def _is_expression(name: str) -> bool:
    return canonical(name) in EXPRESSIONS
