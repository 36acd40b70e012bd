"""py-feat 2 tables: ARKit coefficients but tongueOut, head pose and gaze, one row per face found.

Signs, measured on real tables: Yaw, Roll and Pitch against the rotation of the 478 mesh points
(|r| > .93; positive is toward the subject's right, the subject's right shoulder and down), the gaze
against the eyeLook coefficients (r = .55 and .42; positive is to the subject's left and up). All
are radians. Values of every second frame are common: the clock then runs at half the rate.
"""

from fractions import Fraction
from pathlib import Path

import numpy as np

from mimeline.errors import BadFile
from mimeline.tracking.take import Take, angles, assemble, expressions, numbers, read_columns
from mimeline.vocabulary import EXPRESSIONS, canonical

SIGNS = {
    "Yaw": ("head_yaw_left", -1.0),
    "Pitch": ("head_pitch_up", -1.0),
    "Roll": ("head_tilt_left", -1.0),
    "gaze_yaw": ("gaze_left", 1.0),
    "gaze_pitch": ("gaze_up", 1.0),
}


def read(path: Path, fps: str, bad_values: str) -> Take:
    """Read a table; where a frame holds several faces the surest one is taken.

    fps: rate of the video that was analysed. bad_values: "fail" or "mask".
    Raises BadFile or MissingColumn with line and column.
    """
    table = read_columns(path, text=("frame", "FaceScore"))
    if table.empty:
        raise BadFile(
            path, found="a header alone", expected="at least a frame", remedy="Run py-feat again."
        )
    index, _ = numbers(table, ["frame"], path, "fail")
    score, _ = numbers(table, ["FaceScore"], path, bad_values, blank_ok=True)
    table = table.assign(frame=index["frame"].astype("int64"), FaceScore=score["FaceScore"])
    table = table.sort_values("FaceScore", ascending=False, kind="stable", na_position="last")
    table = table.drop_duplicates("frame").sort_values("frame")

    steps = np.diff(table["frame"])
    stride = int(np.gcd.reduce(steps)) if len(steps) else 1
    frame = ((table["frame"] - table["frame"].iloc[0]) // stride).to_numpy()
    columns = [name for name in table if name in SIGNS or _is_expression(name)]
    values, bad = numbers(table, columns, path, bad_values, blank_ok=True)
    values = values.reset_index(drop=True)
    channels = expressions(values, path)
    radians = angles(values[[c for c in SIGNS if c in values]], "radians", path, "the angles")
    for column in radians:
        name, sign = SIGNS[column]
        channels[name] = sign * radians[column]
    found = table["FaceScore"].notna().to_numpy() & ~bad
    motion = assemble(frame, found, channels, table["FaceScore"].to_numpy(float))
    return Take(motion, Fraction(fps) / stride)


def _is_expression(name: str) -> bool:
    return canonical(name) in EXPRESSIONS
