"""6DRepNet tables: clip_id, frame, and the head's pitch, yaw and roll in degrees."""

from pathlib import Path

import numpy as np
import pandas as pd

from mimeline.errors import BadFile, MissingColumn, unreadable
from mimeline.tracking.convention import Convention
from mimeline.tracking.formats.columns import line_of

CONVENTION = Convention(
    title="6DRepNet table",
    files="one CSV for all clips: clip_id, frame, pitch, yaw, roll",
    coefficients="none",
    axes="of the picture: yaw is positive toward the subject's right, pitch up, roll toward the "
    "left shoulder (clockwise in the picture)",
    rotation="pitch, yaw and roll as the network learnt them from 300W-LP, each taken as it stands",
    angle_unit="degrees",
    sides="the subject's",
    first_frame=0,
    gap="a missing row or an empty cell",
    never="everything but the head",
    evidence="derived, from the published code that draws the head's axes; no recording with a "
    "known turn was at hand",
    signs={
        "yaw": ("head_yaw_left", -1.0),
        "pitch": ("head_pitch_up", 1.0),
        "roll": ("head_tilt_left", 1.0),
    },
)
KEY = ["clip_id", "frame"]


def read_sixdrepnet(path: Path) -> pd.DataFrame:
    """6DRepNet angles in degrees (clip_id, frame, pitch, yaw, roll) → clip_id, frame, head angles.

    Angles are radians in the house's signs, NaN where a cell is empty. Raises BadFile or
    MissingColumn.
    """
    try:
        table = pd.read_csv(path, dtype={"clip_id": str})
    except (ValueError, OSError) as error:
        raise unreadable(
            path,
            error,
            expected="a CSV of 6DRepNet angles",
            remedy="Name it in pose.sixdrepnet.file, or set pose.format: motion.",
        ) from error
    needed = [*KEY, "pitch", "yaw", "roll"]
    if missing := [name for name in needed if name not in table]:
        raise MissingColumn(
            path,
            found=f"columns {', '.join(table)}",
            expected=", ".join(missing),
            remedy="Head the columns clip_id, frame, pitch, yaw, roll.",
        )
    for name in needed[1:]:
        number = pd.to_numeric(table[name], errors="coerce")
        bad = ~(number % 1 == 0 if name == "frame" else number.abs() <= 180)
        bad &= table[name].notna()
        if bad.any():
            row = int(np.argmax(bad))
            raise BadFile(
                path,
                place=f"line {line_of(path, row)}, column {name}",
                found=repr(table[name].iloc[row]),
                expected="a whole number" if name == "frame" else "degrees within half a turn",
                remedy="Fix the cell, or leave it empty.",
            )
    table = table.dropna(subset=KEY)
    pose = table[KEY].astype({"frame": "int64"})
    for column, (channel, sign) in CONVENTION.signs.items():
        pose[channel] = sign * np.radians(table[column].astype(float))
    return pose
