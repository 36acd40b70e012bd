"""Timelines into files: one, or one for each clip of a folder, and what is not kept there."""

import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from mimeline.clips.admission import SAFE_ID
from mimeline.errors import BadFile, NoSuchFile, printable
from mimeline.exchange.reading import Reading
from mimeline.reporting import words
from mimeline.timeline import files
from mimeline.timeline.timeline import Timeline


@dataclass(frozen=True)
class Written:
    """What was written: a file, or a folder with a file for each clip.

    format: its name. timelines: what is in it. lost: what they had and the format does not keep.
    filmed: how many of a folder's files are linked with their video.
    """

    path: Path
    format: str
    timelines: Sequence[Timeline]
    lost: tuple[str, ...]
    filmed: int = 0

    def __str__(self) -> str:
        """One line."""
        intervals = sum(1 for timeline in self.timelines for _ in timeline)
        text = f"wrote {self.path} ({self.format}): {words.plural(intervals, 'interval')}"
        if len(self.timelines) == 1:
            text += f" on {words.plural(len(self.timelines[0].tracks), 'track')}"
        else:
            text += f" of {words.clips(len(self.timelines))}"
        if self.filmed:
            text += f", {words.count(self.filmed)} linked with their video"
        if self.lost:
            text += f"; not kept: {', '.join(self.lost)}"
        if again := self._again():
            text += f"; to read it again: {again}"
        return printable(text)

    def _again(self) -> str:
        """The options that tell what the file does not."""
        rates = {timeline.fps for timeline in self.timelines}
        lengths = {timeline.n_frames for timeline in self.timelines}
        said = []
        if files.FPS in self.lost and len(rates) == 1:
            said += ["--fps", str(rates.pop())]
        if files.N_FRAMES in self.lost and len(lengths) == 1:
            said += ["--frames", str(lengths.pop())]
        return shlex.join(said)


def convert(
    source: Path,
    target: Path,
    reading: Reading,
    format: str | None = None,
    media: Path | None = None,
    overwrite: bool = False,
) -> Written:
    """Read the timelines of a file and write them to another one, or to a folder that is there.

    reading: what is said of source. format: of target, else by its ending. media: the clip's video.
    A folder gets a file for each clip; files that are there already stay, and are an error, but
    where overwrite is true. Raises BadFile as well where target is source, NoSuchFile where media
    is not there.
    """
    timelines = reading.every(source)
    if media is not None and not media.is_file():
        raise NoSuchFile(
            media,
            found="no such file",
            expected="the clip's video",
            remedy="See that the path is right.",
        )
    if target.is_dir():
        if media is not None and len(timelines) > 1:
            raise BadFile(
                media,
                found=f"one video for {len(timelines)} clips",
                expected="the video of one clip",
                remedy="Pick the clip: --clip ID.",
            )
        films = {} if media is None else {timelines[0].clip_id: media}
        return write_each(timelines, target, format, films, overwrite)
    _require_other(target, [source])
    if len(timelines) == 1:
        return write(timelines[0], target, format, media, [source])
    lost = files.write_all(timelines, target, format)
    return Written(target, files.format_of(target, format).name, timelines, lost)


def write(
    timeline: Timeline,
    target: Path,
    format: str | None = None,
    media: Path | None = None,
    sources: Iterable[Path] = (),
) -> Written:
    """Write one timeline. Raises BadFile where target is one of the sources."""
    _require_other(target, sources)
    lost = files.write(timeline, target, format, media)
    return Written(target, files.format_of(target, format).name, [timeline], lost)


def write_each(
    timelines: Sequence[Timeline],
    folder: Path,
    format: str | None,
    films: Mapping[str, Path],
    overwrite: bool = False,
) -> Written:
    """Write a file for each clip into a folder, which is made where it is not there.

    films: clip → its video. Raises BadFile, before anything is written, for a folder without a
    format, a clip whose id is no plain file name, and files that are there already, where overwrite
    does not allow to replace them.
    """
    if format is None:
        raise BadFile(
            folder,
            found="a folder",
            expected="the format of the files in it",
            remedy="Say it, as --to eaf.",
        )
    form = files.format_of(folder, format)
    for timeline in timelines:
        if not SAFE_ID.fullmatch(timeline.clip_id):
            raise BadFile(
                folder,
                found=f"clip {timeline.clip_id!r}",
                expected="ids that are plain file names (a-z 0-9 . _ -)",
                remedy="Rename the clip in the file that it is read from.",
            )
    paths = {t.clip_id: folder / f"{t.clip_id}{form.suffixes[0]}" for t in timelines}
    there = [path for path in paths.values() if path.exists()]
    if there and not overwrite:
        raise BadFile(
            folder,
            found=f"{there[0].name}{f' and {len(there) - 1} more' if there[1:] else ''} already",
            expected="no file of a clip that is to be written",
            remedy="Somebody may have corrected them: name another folder, or say --overwrite.",
        )
    lost = [files.write(t, paths[t.clip_id], format, films.get(t.clip_id)) for t in timelines]
    names = dict.fromkeys(name for own in lost for name in own)
    filmed = 0 if files.MEDIA in form.loses else sum(t.clip_id in films for t in timelines)
    return Written(folder, form.name, timelines, tuple(names), filmed)


def _require_other(target: Path, sources: Iterable[Path]) -> None:
    for source in sources:
        if target.exists() and target.samefile(source):
            raise BadFile(
                target,
                found="the file that is read",
                expected="another one to write to",
                remedy="Name another one; what is there stays.",
            )
