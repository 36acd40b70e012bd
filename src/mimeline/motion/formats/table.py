"""Parquet: the `motion` table of one clip, for pandas and its kin."""

import json
from fractions import Fraction
from pathlib import Path

import pyarrow as pa

from mimeline import tables
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
    rows = tables.read(tables.MOTION, path).drop(columns="clip_id")
    return about.informed(Motion(rows, about.rate(told) or Fraction(0)), told)
