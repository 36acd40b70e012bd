"""Motions read and written again, in other formats."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

from mimeline.errors import BadFile
from mimeline.exchange.reading import Reading
from mimeline.face.model import Face
from mimeline.inspection.options import Options
from mimeline.motion import files
from mimeline.motion.motion import Motion
from mimeline.motion.places import places
from mimeline.motion.resampling import at_rate, resampled
from mimeline.reporting import words
from mimeline.timeline.timeline import Timeline

SLACK = 2  # frames: as much as a motion and its timeline may differ in length


def convert(
    sources: Sequence[Path],
    target: Path,
    to: Sequence[str],
    options: Options,
    fps: Fraction | None,
    timeline: Path | None,
    face: Face,
    overwrite: bool = False,
) -> Iterator[files.Written]:
    """Read motions and write each to a file, or into a folder in each format of `to`.

    options: how tracking results are read. fps: frames per second to bring them to. timeline: what
    one motion does; None: as its file tells. face: for formats that show one. Raises BadFile as
    `files` and `places` do, before anything is written of that motion.
    """
    names = [source.stem for source in sources]
    if timeline is not None and len(sources) > 1:
        raise BadFile(
            timeline,
            found=f"one timeline for {len(sources)} motions",
            expected="the timeline of one",
            remedy="Convert them one by one.",
        )
    wanted = places([target], to, names, sources, overwrite)
    for name, source in zip(names, sources, strict=True):
        motion = files.read(source, options)
        if timeline is not None:
            motion = replace(motion, timeline=_timeline(timeline, motion))
        if fps is not None:
            motion = resampled(motion, fps)
        for path in wanted[name]:
            yield files.write(motion, path, face)


def _timeline(path: Path, motion: Motion) -> Timeline:
    """The timeline of a file on a motion's frames."""
    found = Reading(motion.fps, len(motion)).untold(path)
    if len(found) != 1 or abs(found[0].seconds - motion.seconds) > float(SLACK / motion.fps):
        seconds = ", ".join(f"{own.seconds:.4g} s" for own in found[:5])
        raise BadFile(
            path,
            found=f"{words.plural(len(found), 'timeline')} ({seconds})",
            expected=f"one of {motion.seconds:.4g} s, as the motion has",
            remedy="Name the timeline of this motion.",
        )
    return at_rate(found[0], motion.fps, len(motion))
