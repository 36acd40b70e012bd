"""Which clips turn the head too far for half of the face to be seen."""

import logging
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.clips.head_poses import FORMATS, head_poses
from mimeline.errors import BadFile, MimelineError
from mimeline.ledger import Ledger
from mimeline.tracking.detectors import ENOUGH_FRAMES, FACTOR, OPPOSED, TOLD
from mimeline.tracking.firewall import of_the_set_up
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
    tracker's own head angles, "sixdrepnet" and "openface" tables under data. max_yaw_deg: degrees.
    A clip without any head angle is kept, with a note that the rule could not be applied; one in
    which the table and the tracker turn against each other, or by angles of another size, with a
    note of that.
    Raises BadFile where they do so in most of the sources that move enough, or where the tables
    cannot be read.
    """
    table = tables.read(tables.CLIPS, clips)
    decisions = Ledger("pose", table["clip_id"])
    angles = tables.read(tables.MOTION, motion, ["clip_id", "frame", *HEAD])
    remarks: dict[str, str] = {}
    if format != "motion":
        path, tracked = Path(data) / options["file"], _inside(angles, table)
        angles, remarks = head_poses(table, path, format)
        _cross_check(tracked, angles, table, path, FORMATS[format].unit, decisions)
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
        remark = remarks.get(clip.clip_id)
        if remark or frames < LEAST_COVERED * clip.n_frames:
            detail = "not applied: no head angle is known for this clip"
            if frames:
                detail = f"applied to the {frames} of {clip.n_frames} frames with a head angle"
            detail += f"; {remark}" if remark else ""
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


def _cross_check(
    tracked: pd.DataFrame,
    angles: pd.DataFrame,
    clips: pd.DataFrame,
    path: Path,
    unit: str,
    decisions: Ledger,
) -> None:
    """Hold the table's angles against the tracker's: note what differs, stop where most do."""
    sources = clips[["clip_id", "source_id"]]
    scales = scaled(tracked, angles)
    if fault := scaled_throughout(scales.merge(sources), path, unit):
        raise fault
    agreement = compared(tracked, angles)
    if fault := opposed_throughout(agreement.merge(sources), path):
        raise fault
    for row in _first_of_each(scales[_is_other_unit(scales["ratio"])]).itertuples():
        decisions.note(
            row.clip_id,
            "pose_disagrees",
            value=row.ratio,
            limit=FACTOR if row.ratio > 1 else 1 / FACTOR,
            unit="times what it should be",
            detail=f"{row.angle}: the pose table's angles are not in {unit}, or not the tracker's "
            "in the unit that was told",
        )
    opposed = agreement[agreement["r"] < OPPOSED].sort_values("r", kind="stable")
    for row in _first_of_each(opposed).itertuples():
        decisions.note(
            row.clip_id,
            "pose_disagrees",
            value=row.r,
            limit=OPPOSED,
            unit="correlation",
            detail=f"{row.angle}: the pose table and the tracker turn against each other",
        )


def compared(
    tracked: pd.DataFrame, angles: pd.DataFrame, names: Sequence[str] = HEAD
) -> pd.DataFrame:
    """How well two sources agree about the head's angles.

    tracked, angles: clip_id, frame and the angles in radians. Returns clip_id, angle and r, their
    correlation over the frames that both know, where both move enough to tell.
    """
    rows = [
        (clip_id, name, float(np.corrcoef(pair.T)[0, 1]))
        for clip_id, name, pair in _pairs(tracked, angles, names)
        if pair.std(axis=0).min() >= MOVES
    ]
    return pd.DataFrame(rows, columns=["clip_id", "angle", "r"])


def scaled(
    tracked: pd.DataFrame, angles: pd.DataFrame, names: Sequence[str] = HEAD
) -> pd.DataFrame:
    """How far the second source turns where the first turns, as a ratio.

    tracked, angles: as for `compared`. Returns clip_id, angle and ratio, where one moves enough and
    the two move alike, either way round.
    """
    rows = []
    for clip_id, name, pair in _pairs(tracked, angles, names):
        spread = pair.std(axis=0)  # (2,)
        if spread.max() >= MOVES and spread.min() > 0 and abs(np.corrcoef(pair.T)[0, 1]) >= TOLD:
            rows.append((clip_id, name, float(spread[1] / spread[0])))
    return pd.DataFrame(rows, columns=["clip_id", "angle", "ratio"])


def _pairs(
    tracked: pd.DataFrame, angles: pd.DataFrame, names: Sequence[str]
) -> Iterator[tuple[str, str, np.ndarray]]:
    """(clip_id, angle, both sources' values (m, 2)) where enough frames know it."""
    both = tracked.merge(angles, on=["clip_id", "frame"], suffixes=("", "_there"))
    for clip_id, frames in both.groupby("clip_id"):
        for name in names:
            pair = frames[[name, f"{name}_there"]].dropna().to_numpy(float)  # (m, 2)
            if len(pair) >= ENOUGH_FRAMES:
                yield clip_id, name, pair


def _is_other_unit(ratio: pd.Series) -> pd.Series:
    return (ratio > FACTOR) | (ratio < 1 / FACTOR)


def scaled_throughout(scales: pd.DataFrame, path: Path, unit: str) -> MimelineError | None:
    """The error to stop with, where most sources that can tell have angles of another unit.

    scales: as `scaled` gives it, with source_id; clips of one source are one. path: the pose table.
    unit: that its format has.
    """
    wrong = scales[_is_other_unit(scales["ratio"])]
    shown, could = wrong["source_id"].nunique(), scales["source_id"].nunique()
    if not of_the_set_up(shown, could):
        return None
    first = wrong.iloc[0]
    return BadFile(
        path,
        place=f"{shown} of the {could} sources that move enough",
        found=f"{first.angle} {first.ratio:.3g} times that of the tracking results in "
        f"{first.clip_id}",
        expected=f"angles in {unit}, as large as the tracker's",
        remedy="Convert the table's angles, or the unit of the tracker's under ingest; or set "
        "pose.format: motion.",
    )


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


def _first_of_each(rows: pd.DataFrame) -> pd.DataFrame:
    return rows.drop_duplicates("clip_id")


def _inside(angles: pd.DataFrame, clips: pd.DataFrame) -> pd.DataFrame:
    """Rows of the clips' own frames."""
    rows = angles.merge(clips[["clip_id", "n_frames"]], on="clip_id")
    return rows[rows["frame"].between(0, rows["n_frames"] - 1)].drop(columns="n_frames")
