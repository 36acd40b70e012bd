"""Timelines into files, one, or one for each clip in a folder, and what is not kept there."""

import shlex
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from mimeline.clips.admission import SAFE_ID
from mimeline.errors import BadFile, NoSuchFile, printable
from mimeline.exchange.reading import Reading
from mimeline.reporting import words
from mimeline.targets import is_folder, require_folder, require_free, require_new
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
            those = f"{words.count(self.filmed)} linked with their"
            text += f", {'linked with its' if len(self.timelines) == 1 else those} video"
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
    """Read the timelines of a file, or of those in a folder, and write them to a file or a folder.

    target: a folder where it is one, or where it is not there and has no ending; a folder gets a
    file for each clip. reading: what is said of source. format: of target, else by its ending.
    media: the clip's video. Raises BadFile as `write` and `write_each` do, NoSuchFile where media
    is not there.
    """
    read = reading.folder(source) if source.is_dir() else {source: reading.every(source)}
    timelines = [timeline for own in read.values() for timeline in own]
    if is_folder(target):
        if media is not None and len(timelines) > 1:
            raise BadFile(
                media,
                found=f"one video for {len(timelines)} clips",
                expected="the video of one clip",
                remedy="Pick the clip: --clip ID.",
            )
        _require_video(media)
        films = {} if media is None else {timelines[0].clip_id: media}
        return write_each(timelines, target, format, films, read, overwrite)
    if len(timelines) == 1:
        return write(timelines[0], target, format, media, read, overwrite)
    require_free(target, read, overwrite)
    lost = files.write_all(timelines, target, format)
    return Written(target, files.format_of(target, format).name, timelines, lost)


def write(
    timeline: Timeline,
    target: Path,
    format: str | None = None,
    media: Path | None = None,
    sources: Collection[Path] = (),
    overwrite: bool = False,
) -> Written:
    """Write one timeline.

    media: the clip's video. sources: the files that it is made of. Raises BadFile where target is
    one of them, is no file, or is there already, unless overwrite allows to replace it; NoSuchFile
    where media is not there.
    """
    _require_video(media)
    require_free(target, sources, overwrite)
    lost = files.write(timeline, target, format, media)
    return Written(target, files.format_of(target, format).name, [timeline], lost)


def write_each(
    timelines: Sequence[Timeline],
    folder: Path,
    format: str | None,
    films: Mapping[str, Path],
    sources: Collection[Path] = (),
    overwrite: bool = False,
) -> Written:
    """Write a file for each clip into a folder, which is made where it is not there.

    films: clip → its video. sources: as for write. Raises BadFile, before anything is written, for
    a folder that is a file, or without a format, a clip whose id is no plain file name, and files
    that are there already, unless overwrite allows to replace them.
    """
    require_folder(folder)
    if format is None:
        raise BadFile(
            folder,
            found="a folder" if folder.is_dir() else "a name without an ending, as a folder has",
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
    there = require_new(folder, paths.values(), overwrite)
    for path in there:
        require_free(path, sources, overwrite)
    lost = [files.write(t, paths[t.clip_id], format, films.get(t.clip_id)) for t in timelines]
    names = dict.fromkeys(name for own in lost for name in own)
    filmed = 0 if files.MEDIA in form.loses else sum(t.clip_id in films for t in timelines)
    return Written(folder, form.name, timelines, tuple(names), filmed)


def _require_video(media: Path | None) -> None:
    if media is not None and not media.is_file():
        raise NoSuchFile(
            media,
            found="no such file",
            expected="the clip's video",
            remedy="See that the path is right.",
        )
