"""Which clips turn the head too far for half of the face to be seen."""

import logging
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.errors import BadFile, MissingColumn
from mimeline.ledger import Ledger

log = logging.getLogger(__name__)


def pose(
    clips: Path,
    motion: Path,
    data: Path,
    kept: Path,
    ledger: Path,
    format: str,
    options: dict,
    max_yaw_deg: float,
) -> None:
    """Drop the clips in which a frame's |yaw| passes the limit (Höll 2024, 5.1).

    clips, kept: `clips` tables in and out. motion: the shard's motion. format: "motion" takes the
    tracker's own head angles, "sixdrepnet" a table under data. max_yaw_deg: degrees.
    A clip without any head angle is kept, with a note that the rule could not be applied.
    """
    table = tables.read(tables.CLIPS, clips)
    if format == "sixdrepnet":
        angles = read_sixdrepnet(Path(data) / options["file"])
    else:
        angles = tables.read(tables.MOTION, motion, ["clip_id", "frame", "head_yaw_left"])
    decisions = Ledger("pose", table["clip_id"])
    angles = angles[angles["clip_id"].isin(table["clip_id"])].dropna(subset=["head_yaw_left"])
    for turned in mask_turned(angles, np.radians(max_yaw_deg)).itertuples():
        decisions.drop(
            turned.clip_id,
            "turned",
            value=np.degrees(turned.value),
            limit=max_yaw_deg,
            unit="deg",
            first_frame=turned.first_frame,
            last_frame=turned.last_frame,
        )
    for clip_id in sorted(set(table["clip_id"]) - set(angles["clip_id"])):
        detail = "not applied: no head angle is known for this clip"
        decisions.note(clip_id, "turned", limit=max_yaw_deg, unit="deg", detail=detail)
    table = table[table["clip_id"].isin(decisions.kept)]
    tables.write(tables.CLIPS, table, kept)
    decisions.close(ledger, table["clip_id"])
    log.info("%s", decisions)


def mask_turned(angles: pd.DataFrame, max_yaw: float) -> pd.DataFrame:
    """The clips whose head turns too far.

    angles: clip_id, frame, head_yaw_left (radians). max_yaw: limit of |yaw|, radians.
    Returns clip_id, value (the largest |yaw|), first_frame and last_frame past the limit.
    """
    past = angles.assign(value=angles["head_yaw_left"].abs())
    past = past[past["value"] > max_yaw]
    return past.groupby("clip_id", as_index=False).agg(
        value=("value", "max"), first_frame=("frame", "min"), last_frame=("frame", "max")
    )


def read_sixdrepnet(path: Path) -> pd.DataFrame:
    """6DRepNet angles in degrees (clip_id, frame, pitch, yaw, roll) → clip_id, frame, head angles.

    6DRepNet draws +yaw toward the left of the picture, the subject's own right; +pitch is up; +roll
    is clockwise in the picture, toward the subject's left shoulder.
    """
    try:
        table = pd.read_csv(path, dtype={"clip_id": str})
    except FileNotFoundError as error:
        raise BadFile(
            path,
            found="no such file",
            expected="a table of 6DRepNet angles",
            remedy="Name it in pose.sixdrepnet.file, or set pose.format: motion.",
        ) from error
    except (ValueError, UnicodeDecodeError) as error:
        raise BadFile(
            path,
            found=str(error),
            expected="a CSV of 6DRepNet angles",
            remedy="Write it anew, with columns clip_id, frame, pitch, yaw, roll.",
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
        bad = pd.to_numeric(table[name], errors="coerce").isna() & table[name].notna()
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
