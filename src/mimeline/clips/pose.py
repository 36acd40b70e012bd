"""Which clips turn the head too far for half of the face to be seen."""

import logging
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.errors import BadFile, MimelineError
from mimeline.ledger import Ledger
from mimeline.tracking.detectors import ENOUGH_FRAMES, OPPOSED
from mimeline.tracking.firewall import of_the_set_up
from mimeline.tracking.formats.sixdrepnet import read_sixdrepnet
from mimeline.tracking.loss import LEAST_COVERED
from mimeline.vocabulary import HEAD

log = logging.getLogger(__name__)

MOVES = 0.03  # radians: standard deviation of a head angle, from which two sources must agree


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
    A clip without any head angle is kept, with a note that the rule could not be applied; one in
    which the table and the tracker turn against each other, with a note of that.
    Raises BadFile where they do so in most of the sources that move enough.
    """
    table = tables.read(tables.CLIPS, clips)
    decisions = Ledger("pose", table["clip_id"])
    angles = tables.read(tables.MOTION, motion, ["clip_id", "frame", *HEAD])
    if format == "sixdrepnet":
        path = Path(data) / options["file"]
        tracked, angles = angles, read_sixdrepnet(path)
        agreement = compared(_inside(tracked, table), _inside(angles, table))
        if fault := opposed_throughout(agreement.merge(table[["clip_id", "source_id"]]), path):
            raise fault
        for row in _opposed(agreement).itertuples():
            decisions.note(
                row.clip_id,
                "pose_disagrees",
                value=row.r,
                limit=OPPOSED,
                unit="correlation",
                detail=f"{row.angle}: the pose table and the tracker turn against each other",
            )
    angles = _inside(angles, table).dropna(subset=["head_yaw_left"])
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


def compared(
    tracked: pd.DataFrame, angles: pd.DataFrame, names: Sequence[str] = HEAD
) -> pd.DataFrame:
    """How well two sources agree about the head's angles.

    tracked, angles: clip_id, frame and the angles in radians. Returns clip_id, angle and r, their
    correlation over the frames that both know, where both move enough to tell.
    """
    rows = []
    both = tracked.merge(angles, on=["clip_id", "frame"], suffixes=("", "_there"))
    for clip_id, frames in both.groupby("clip_id"):
        for name in names:
            pair = frames[[name, f"{name}_there"]].dropna().to_numpy(float)  # (m, 2)
            if len(pair) >= ENOUGH_FRAMES and pair.std(axis=0).min() >= MOVES:
                rows.append((clip_id, name, float(np.corrcoef(pair.T)[0, 1])))
    return pd.DataFrame(rows, columns=["clip_id", "angle", "r"])


def opposed_throughout(agreement: pd.DataFrame, path: Path) -> MimelineError | None:
    """The error to stop with, where most sources that can tell have an angle the other way round.

    agreement: as `compared` gives it, with source_id; clips of one source are one. path: the pose
    table.
    """
    for angle, clips in agreement.groupby("angle"):
        opposed = clips[clips["r"] < OPPOSED]
        shown, could = opposed["source_id"].nunique(), clips["source_id"].nunique()
        if not of_the_set_up(shown, could):
            continue
        first = opposed.iloc[0]
        return BadFile(
            path,
            place=f"{shown} of the {could} sources that move enough",
            found=f"{angle} against that of the tracking results, r = {first.r:.2f} in "
            f"{first.clip_id}",
            expected="a table and tracking results of the same pictures, that turn the same way",
            remedy="Where the tracker saw mirrored pictures, set ingest.mirrored: true; where "
            "another tool wrote the table, correct its signs, or set pose.format: motion.",
        )
    return None


def _opposed(agreement: pd.DataFrame) -> pd.DataFrame:
    """The angle in which a clip disagrees most, of each clip that disagrees."""
    opposed = agreement[agreement["r"] < OPPOSED].sort_values("r", kind="stable")
    return opposed.drop_duplicates("clip_id")


def _inside(angles: pd.DataFrame, clips: pd.DataFrame) -> pd.DataFrame:
    """Rows of the clips' own frames."""
    rows = angles.merge(clips[["clip_id", "n_frames"]], on="clip_id")
    return rows[rows["frame"].between(0, rows["n_frames"] - 1)].drop(columns="n_frames")
