"""Parquet: the `motion` table of one clip, for pandas and its kin."""

import json
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from mimeline import tables
from mimeline.errors import BadFile
from mimeline.motion import about
from mimeline.motion.motion import Motion


def write(motion: Motion, path: Path) -> None:
    """Write the table; what travels with the motion is in the file's metadata."""
    told = json.dumps(about.about(motion), ensure_ascii=False, allow_nan=False)
    name = path.stem if motion.timeline is None else motion.timeline.clip_id
    tables.write(tables.MOTION, motion.frames.assign(clip_id=name), path, about=told)


def holds(path: Path) -> bool:
    """Whether a Parquet file is a `motion` table, of one clip or of a run's."""
    try:
        return pq.read_schema(path).names == tables.MOTION.schema.names
    except (OSError, pa.ArrowException, UnicodeDecodeError):
        return False


def read(path: Path) -> Motion:
    """The motion of a file. Raises BadFile for that of several clips, or without a rate, and as
    tables.read does."""
    noted = tables.about(path)
    told = about.parsed(noted, path) if noted else {}
    rows, fps = tables.read(tables.MOTION, path), about.rate(told)
    if (clips := rows["clip_id"].nunique()) != 1:
        raise _refused(path, f"the frames of {clips} clips")
    if not np.array_equal(rows["frame"], np.arange(len(rows))):
        raise _refused(path, "frames that do not count from 0 on")
    if fps is None:
        raise _refused(path, "no frames per second")
    return about.informed(Motion(rows.drop(columns="clip_id"), fps), told)


def _refused(path: Path, found: str) -> BadFile:
    return BadFile(
        path,
        found=found,
        expected="the motion of one clip, with frames per second",
        remedy="`mimeline motion export` takes clips out of a run.",
    )
