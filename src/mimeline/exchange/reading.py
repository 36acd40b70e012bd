"""Files of timelines, read with what the user says of them."""

from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from mimeline.errors import BadFile
from mimeline.timeline import files
from mimeline.timeline.clock import frame_rate
from mimeline.timeline.draft import Draft
from mimeline.timeline.timeline import Timeline


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
        self._require_one(path, self._drafts(path))
        return files.read(path, self.fps, self.n_frames, self.clip_id, self.format)

    def every(self, path: Path) -> list[Timeline]:
        """The timelines of all clips of the file, or of the one that is meant."""
        if self.clip_id is not None:
            return [self.one(path)]
        return files.read_all(path, self.fps, self.n_frames, self.format)

    def both(self, a: Path, b: Path) -> tuple[Timeline, Timeline]:
        """The timelines of two files of a clip: what one of them does not tell, the other does."""
        drafts = [self._require_one(path, self._drafts(path)) for path in (a, b)]
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

    def _drafts(self, path: Path) -> list[Draft]:
        drafts = files.format_of(path, self.format).read(path)
        if self.clip_id is None:
            return drafts
        return [draft for draft in drafts if draft.clip_id in (None, self.clip_id)] or drafts

    def _require_one(self, path: Path, drafts: list[Draft]) -> Draft:
        if len(drafts) > 1:
            raise BadFile(
                path,
                found=f"{len(drafts)} clips, {drafts[0].clip_id} the first of them",
                expected="one",
                remedy="Say which one: --clip ID.",
            )
        return drafts[0] if drafts else Draft(None, (), in_seconds=False)


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
