"""6DRepNet tables: clip_id, frame, and the head's pitch, yaw and roll in degrees."""

from pathlib import Path

import numpy as np
import pandas as pd

from mimeline.errors import BadFile, MissingColumn, unreadable


def read_sixdrepnet(path: Path) -> pd.DataFrame:
    """6DRepNet angles in degrees (clip_id, frame, pitch, yaw, roll) → clip_id, frame, head angles.

    6DRepNet draws +yaw toward the left of the picture, the subject's own right; +pitch is up; +roll
    is clockwise in the picture, toward the subject's left shoulder.
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
    needed = ["clip_id", "frame", "pitch", "yaw", "roll"]
    if missing := [name for name in needed if name not in table]:
        raise MissingColumn(
            path,
            found=f"columns {', '.join(table)}",
            expected=", ".join(missing),
            remedy="Head the columns clip_id, frame, pitch, yaw, roll.",
        )
    for name in needed[1:]:
        number = pd.to_numeric(table[name], errors="coerce")
        bad = ~np.isfinite(number) & table[name].notna()
        if bad.any():
            row = int(np.argmax(bad))
            raise BadFile(
                path,
                place=f"line {row + 2}, column {name}",
                found=repr(table[name].iloc[row]),
                expected="a number",
                remedy="Fix the cell, or leave it empty.",
            )
    table = table.dropna(subset=["clip_id", "frame"])
    return pd.DataFrame(
        {
            "clip_id": table["clip_id"],
            "frame": table["frame"].astype("int64"),
            "head_yaw_left": -np.radians(table["yaw"].astype(float)),
            "head_pitch_up": np.radians(table["pitch"].astype(float)),
            "head_tilt_left": np.radians(table["roll"].astype(float)),
        }
    )
