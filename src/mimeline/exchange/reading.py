"""Files of timelines, read with what the user says of them."""

from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from mimeline.errors import BadFile, NoSuchFile
from mimeline.timeline import files
from mimeline.timeline.clock import frame_rate, seconds
from mimeline.timeline.draft import Draft
from mimeline.timeline.timeline import Timeline

MOST_SECONDS = 3600  # of a clip that is said to be so long


@dataclass(frozen=True)
class Reading:
    """What a user says of files that need not tell it themselves; None: nothing.

    clip_id: the one that is meant, in a file of several; what it is called, in a file of none.
    format: one of files.FORMATS, whatever the file's name ends in.
    """

    fps: Fraction | None = None
    n_frames: int | None = None
    clip_id: str | None = None
    format: str | None = None

    def one(self, path: Path) -> Timeline:
        """The timeline of one clip. Raises BadFile where there are errors, or several clips."""
        require_file(path)
        return files.read(path, self.fps, self.n_frames, self.clip_id, self.format)

    def every(self, path: Path) -> list[Timeline]:
        """The timelines of all clips of the file, or of the one that is meant."""
        if self.clip_id is not None:
            return [self.one(path)]
        require_file(path)
        return files.read_all(path, self.fps, self.n_frames, self.format)

    def untold(self, path: Path) -> list[Timeline]:
        """As `every`, but what the file tells itself goes before what is said of it."""
        require_file(path)
        drafts = files.drafts(path, self.format)
        fps = {name: self.fps for name, draft in drafts if draft.fps is None and self.fps}
        lengths = {
            name: self.n_frames
            for name, draft in drafts
            if draft.n_frames is None and self.n_frames is not None
        }
        wanted = None
        if self.clip_id is not None:
            named = files.draft_of(path, self.clip_id, self.format).clip_id
            wanted = [name for name, draft in drafts if draft.clip_id == named]
        return files.read_all(path, fps, lengths, self.format, wanted)

    def folder(self, folder: Path) -> dict[Path, list[Timeline]]:
        """The timelines of each file in a folder.

        Raises NoSuchFile where there is none; BadFile as `every` does, where two files are of the
        same clip, and where one clip is meant.
        """
        if self.clip_id is not None:
            raise BadFile(
                folder,
                found="a folder, with --clip",
                expected="a file where one clip is meant",
                remedy="Name the clip's file, or leave --clip out.",
            )
        there = files.files_in(folder)
        if not there:
            raise NoSuchFile(
                folder,
                found="no file of timelines",
                expected=f"files that end in {', '.join(files.SUFFIXES)}",
                remedy="See that the path is right.",
            )
        found, by_clip = {path: self.every(path) for path in there}, {}
        for path, timelines in found.items():
            for timeline in timelines:
                other = by_clip.setdefault(timeline.clip_id, path)
                if other != path:
                    raise BadFile(
                        path,
                        place=f"clip {timeline.clip_id}",
                        found=f"a clip that is in {other} too",
                        expected="one file of each clip",
                        remedy="Move one of them out of the folder.",
                    )
        return found

    def both(self, a: Path, b: Path) -> tuple[Timeline, Timeline]:
        """The timelines of two files of a clip: what one of them does not tell, the other does."""
        drafts = [self._draft(path) for path in (a, b)]
        fps = self.fps or next((draft.fps for draft in drafts if draft.fps), None)
        lengths = (draft.n_frames for draft in drafts if draft.n_frames is not None)
        n_frames = self.n_frames or next(lengths, None)
        clip_id = self.clip_id or next((draft.clip_id for draft in drafts if draft.clip_id), None)
        first, second = (
            files.read(
                path,
                self.fps if draft.fps else fps,
                self.n_frames if draft.n_frames is not None else n_frames,
                self.clip_id if draft.clip_id else clip_id,
                self.format,
            )
            for path, draft in zip((a, b), drafts, strict=True)
        )
        return first, second

    def _draft(self, path: Path) -> Draft:
        require_file(path)
        return files.draft_of(path, self.clip_id, self.format)


def require_file(path: Path) -> None:
    """Raises BadFile for a folder."""
    if path.is_dir():
        raise BadFile(
            path,
            found="a folder",
            expected="a file of timelines",
            remedy=f"Name the files in it: {path}/*.",
        )


def rate_said(text: str | None) -> Fraction | None:
    """The frame rate of --fps. Raises BadFile for what is none."""
    try:
        return None if text is None else frame_rate(text)
    except ValueError as error:
        raise BadFile(
            "--fps",
            found=repr(text),
            expected="frames per second",
            remedy="Write 25, 29.97 or 30000/1001.",
        ) from error


def length_said(n_frames: int | None) -> int | None:
    """The length of --frames. Raises BadFile for none that a clip has."""
    if n_frames is not None and n_frames < 1:
        raise BadFile(
            "--frames",
            found=str(n_frames),
            expected="how many frames the clip has",
            remedy="Write 1 or more.",
        )
    return n_frames


def seconds_said(text: str | None) -> Fraction | None:
    """The length of --seconds. Raises BadFile for none that a clip has."""
    try:
        told = None if text is None else seconds(text)
    except ValueError:
        told = Fraction(0)
    if told is not None and not 0 < told <= MOST_SECONDS:
        raise BadFile(
            "--seconds",
            found=repr(text),
            expected=f"how long the clip is, at most {MOST_SECONDS}",
            remedy="Write 5 or 4.5.",
        )
    return told


def format_said(text: str | None, option: str) -> str | None:
    """The format that a name or an ending means (elan, eaf, .eaf). Raises BadFile for none."""
    if text is None:
        return None
    asked = text.casefold().removeprefix(".")
    for form in files.FORMATS.values():
        endings = (suffix.removeprefix(".").casefold() for suffix in form.suffixes)
        if asked in (form.name, *endings):
            return form.name
    raise BadFile(
        option,
        found=repr(text),
        expected="a format of timelines",
        remedy=f"There are {', '.join(files.FORMATS)}.",
    )
