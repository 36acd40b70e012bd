"""Parquet: the `motion` table of one clip, for pandas and its kin."""

import json
from pathlib import Path

import numpy as np
import pyarrow as pa

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
    """Whether a Parquet file is a motion of ours."""
    try:
        return bool(tables.about(path))
    except (OSError, pa.ArrowException, UnicodeDecodeError):
        return False


def read(path: Path) -> Motion:
    """The motion of a file. Raises BadFile as tables.read does."""
    told = about.parsed(tables.about(path), path)
    rows, fps = tables.read(tables.MOTION, path), about.rate(told)
    whole = len(rows) and np.array_equal(rows["frame"], np.arange(len(rows)))
    if fps is None or not whole or rows["clip_id"].nunique() > 1:
        found = "no frames per second" if fps is None else "frames of several clips, or gaps"
        raise BadFile(
            path,
            found=found,
            expected="the motion of one clip, its frames from 0 on, with frames per second",
            remedy="Write it again; mimeline motion export takes clips out of a run.",
        )
    return about.informed(Motion(rows.drop(columns="clip_id"), fps), told)
