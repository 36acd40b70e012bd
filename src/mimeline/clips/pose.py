"""Which clips turn the head too far for half of the face to be seen."""

import logging
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.ledger import Ledger
from mimeline.tracking.sixdrepnet import read_sixdrepnet

log = logging.getLogger(__name__)

LEAST_COVERED = 0.9  # share of a clip's frames with a head angle, below which the ledger says so


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
    angles = angles.merge(table[["clip_id", "n_frames"]], on="clip_id")
    within = angles["frame"].between(0, angles["n_frames"] - 1)
    angles = angles[within].dropna(subset=["head_yaw_left"])
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
    known = angles.groupby("clip_id").size()
    for clip in table[table["clip_id"].isin(decisions.kept)].itertuples():
        frames = int(known.get(clip.clip_id, 0))
        if frames < LEAST_COVERED * clip.n_frames:
            detail = "not applied: no head angle is known for this clip"
            if frames:
                detail = f"applied to the {frames} of {clip.n_frames} frames with a head angle"
            decisions.note(clip.clip_id, "turned", limit=max_yaw_deg, unit="deg", detail=detail)
    table = table[table["clip_id"].isin(decisions.kept)]
    tables.write(tables.CLIPS, table, kept)
    decisions.close(ledger, table["clip_id"])
    decisions.tell(log)


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
