"""Live Link Face CSV, as the app writes it; what it has no place for lies beside it."""

from pathlib import Path

from mimeline.motion.about import write_beside
from mimeline.motion.motion import Motion
from mimeline.tracking.formats import livelink

TIMECODE_BASE = 60


def write(motion: Motion, path: Path) -> None:
    """Write a take: rotations in radians, a timecode that begins at 0 and counts in sixtieths."""
    livelink.write(path, motion.frames, motion.fps, timecode_base=TIMECODE_BASE)
    told = {"angle_unit": "radians", "timecode_base": TIMECODE_BASE}
    write_beside(path, motion, livelink=told)
