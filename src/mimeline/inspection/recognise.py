"""Telling what a path is at a glance, before it is read."""

from pathlib import Path

from mimeline.clips.catalogues.films import ENDINGS as VIDEOS
from mimeline.inspection.catalogues import catalogue_kind, list_kind
from mimeline.inspection.files import (
    LOSSES,
    is_head_poses,
    is_losses,
    table_by_columns,
    table_name,
)
from mimeline.inspection.options import Options
from mimeline.tracking.readers import READERS


def format_of(path: Path, options: Options) -> str | None:
    """The format that the take at path is read as; None where it is none.

    A format that somebody named is believed of every file that has one of its endings; that of a
    configuration of every take, and of all that lies in the folder of its takes.
    """
    asked = options.format if options.format and may_be(path, options.format) else None
    if options.named or (asked and options.is_of_the_run(path)):
        return asked
    found = recognised(path, options)
    return asked if asked and found else found


def recognised(path: Path, options: Options) -> str | None:
    """The format that a take looks like, by what is in it; None where it looks like none."""
    if table_by_columns(path) or list_kind(path):
        return None
    formats = sorted(READERS, key=lambda name: name != options.format)  # stable: the rest in order
    return next((f for f in formats if may_be(path, f) and READERS[f].holds(path)), None)


def may_be(path: Path, format: str) -> bool:
    """Whether a path could be a take, by its ending alone; a folder by what is in it."""
    reader = READERS[format]
    if is_losses(path):
        return False
    if reader.endings:
        return path.suffix.lower() in reader.endings and path.is_file()
    return path.is_dir() and reader.holds(path)


def is_video(path: Path) -> bool:
    """Whether a file is named as a video."""
    return path.suffix.lower() in VIDEOS and path.is_file()


def video_of(take: Path, options: Options) -> Path | None:
    """The video that bears a take's name: in the folder of a run's videos, or beside the take."""
    take = take.absolute()  # "." has no name
    stem = take.name if take.is_dir() else take.stem
    folders = filter(None, (options.videos, take.parent))
    videos = (folder / f"{stem}{ending}" for folder in folders for ending in VIDEOS)
    return next(filter(is_video, videos), None)


def kind_of(path: Path, options: Options) -> str | None:
    """What a path is, in a few words; None where it is not known, or a folder of other things."""
    if format := format_of(path, options) if options.named else recognised(path, options):
        return READERS[format].convention.title
    if is_losses(path):
        return LOSSES
    if is_video(path):
        return "video"
    if kind := list_kind(path):
        return kind
    if path.suffix.lower() == ".parquet" and (name := table_name(path)):
        return f"table {name}"
    if kind := catalogue_kind(path):
        return kind
    return "6DRepNet table" if path.suffix.lower() == ".csv" and is_head_poses(path) else None
