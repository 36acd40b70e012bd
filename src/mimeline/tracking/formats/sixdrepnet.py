"""6DRepNet tables: the head's pitch, yaw and roll in degrees, of a clip or of many.

6DRepNet itself writes no file, so these are people's own: names in any case, frames counted or not.
"""

from collections.abc import Collection
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline.errors import BadFile, NoSuchFile
from mimeline.tracking.convention import Convention
from mimeline.tracking.formats.clip_tables import read_clips
from mimeline.tracking.formats.columns import line_of, read_columns
from mimeline.tracking.formats.missing import blanked

CONVENTION = Convention(
    title="6DRepNet table",
    files="one CSV for all clips: clip_id, frame, pitch, yaw, roll; or a folder with one for each, "
    "without clip_id",
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
ANGLES = tuple(CONVENTION.signs)


def read_sixdrepnet(path: Path, clips: Collection[str] | None = None) -> pd.DataFrame:
    """6DRepNet angles in degrees (clip_id, frame, pitch, yaw, roll) → clip_id, frame, head angles.

    clips: whose rows to read; None: all. Angles are radians in the house's signs, NaN where a cell
    is empty. Raises BadFile or MissingColumn.
    """
    if not Path(path).exists():
        raise NoSuchFile(
            path,
            found="no such file",
            expected="a CSV of 6DRepNet angles",
            remedy="Name it in pose.sixdrepnet.file, or set pose.format: motion.",
        )
    return _angles(read_clips(path, ("frame", *ANGLES), (), clips), path)


def read_head(path: Path) -> pd.DataFrame:
    """As `read_sixdrepnet`, of a table of one clip: frame and angles.

    Without a column frame, rows are frames from 0 on.
    """
    table = read_columns(path, needed=ANGLES, known=("frame",))
    if "frame" not in table:
        table = table.assign(frame=np.arange(len(table)))
    return _angles(table, path)


def _angles(table: pd.DataFrame, path: Path) -> pd.DataFrame:
    """The columns clip_id, where there is one, frame and the angles, checked."""
    cells, _ = blanked(table[["frame", *ANGLES]])
    values = cells.apply(pd.to_numeric, errors="coerce").astype(float)
    given = cells.astype(str).ne("").to_numpy()
    allowed = (values.abs() <= 180).assign(frame=values["frame"].between(0, 2**53))
    allowed["frame"] &= values["frame"] % 1 == 0
    if (bad := given & ~allowed.to_numpy()).any():
        row, column = np.argwhere(bad)[0]
        raise BadFile(
            path,
            place=f"line {line_of(path, table.index[row])}, column {cells.columns[column]}",
            found=repr(cells.iat[row, column]),
            expected="degrees within half a turn" if column else "a whole number from 0 on",
            remedy="Fix the cell, or leave it empty.",
        )
    counted = values["frame"].notna()
    pose = table.loc[counted, [name for name in ("clip_id",) if name in table]]
    pose["frame"] = values.loc[counted, "frame"].astype("int64")
    if (repeated := pose.duplicated()).any():
        raise BadFile(
            path,
            place=f"line {line_of(path, repeated.idxmax())}, column frame",
            found=f"frame {pose.at[repeated.idxmax(), 'frame']} of a clip again",
            expected="each frame of a clip once",
            remedy="Keep the rows of one face.",
        )
    for column, (channel, sign) in CONVENTION.signs.items():
        pose[channel] = sign * np.radians(values.loc[counted, column])
    return pose.reset_index(drop=True)
