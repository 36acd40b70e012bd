"""A clip's tracking result: its own or its seconds of its source's, at the clip's length."""

from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline.errors import MimelineError, NoSuchFile
from mimeline.tracking import firewall, loss
from mimeline.tracking.readers import Tracker
from mimeline.tracking.take import Take

TOLERANCE = 2.0  # frames: catalogues round seconds to 1/100, trackers skip a first or last frame


@dataclass(frozen=True)
class Result:
    """What the tracking result at path says, or a part of it.

    take: with its loss, and its lost frames not valid. zero: (n,) bool, the frames that are lost
    since every coefficient is 0. start: the frame that the part begins at; whole: frames in all.
    """

    path: Path
    take: Take
    zero: np.ndarray
    start: int
    whole: int

    @classmethod
    def read(cls, tracker: Tracker, path: Path, max_loss: float | None) -> "Result":
        """The whole result. max_loss: the limit of the tracker's own loss, or None.

        Raises MimelineError where it, or the loss beside it, cannot be read.
        """
        told = loss.with_loss(tracker.read(path), path, max_loss)
        take, zero = firewall.without_lost(told), firewall.lost_frames(told)
        return cls(path, take, zero, start=0, whole=len(take.motion))

    def cut(self, start: int, end: int) -> "Result":
        """Frames [start, end) of a whole result."""
        take, zero = self.take.cut(start, end), self.zero[start:end]
        return Result(self.path, take, zero, start, self.whole)


class Results:
    """The tracking results that clips need, each read once for clips that follow each other.

    names: of those that were looked into. errors: name → why it cannot be read.
    """

    def __init__(self, tracker: Tracker, max_loss: float | None) -> None:
        self.tracker, self.max_loss = tracker, max_loss
        self.names: set[str] = set()
        self.errors: dict[str, MimelineError] = {}
        self._last: Result | None = None

    def of(self, clip) -> Result:
        """The clip's own result, else its seconds of its source's, as long as the tracker says.

        clip: a row of `clips`. Raises MimelineError where it cannot be read, NoSuchFile where
        there is none.
        """
        if own := self.tracker.result(clip.clip_id):
            return self._read(own)
        if path := self.tracker.result(clip.source_id):
            whole = self._read(path)
            fps = whole.take.fps
            return whole.cut(round(clip.start_s * fps), round(clip.end_s * fps))
        raise NoSuchFile(
            self.tracker.folder / clip.clip_id,
            found="no such file or folder",
            expected=f"a {self.tracker.reader.convention.title} of the clip or of {clip.source_id}",
            remedy="Check data_dir and the folder in the ingest section.",
        )

    def _read(self, path: Path) -> Result:
        self.names.add(path.name)
        if error := self.errors.get(path.name):
            raise error.with_traceback(None)
        if self._last is None or self._last.path != path:
            try:
                self._last = Result.read(self.tracker, path, self.max_loss)
            except MimelineError as error:
                self.errors[path.name] = error
                raise
        return self._last


def of_another_cut(clip, result: Result) -> tuple[str, dict] | None:
    """Rule and facts where the result cannot be that of the clip: another rate or length."""
    take = result.take
    if result.start >= result.whole:
        end_s = float(result.whole / take.fps)
        detail = (
            f"{result.path.name} ends after {end_s:.2f} s, the clip begins at {clip.start_s:g} s"
        )
        facts = {"value": result.whole, "limit": result.start, "unit": "frames"}
        return "shorter_than_clip", facts | {"detail": detail}
    if filmed(clip):
        return of_another_film(take, Fraction(int(clip.fps_num), int(clip.fps_den)), clip.n_frames)
    return _too_long(take, _expected(clip, take))


def of_another_film(take: Take, rate: Fraction, n_frames: int) -> tuple[str, dict] | None:
    """Rule and facts where the result cannot be that of a video of n_frames at a rate.

    A result whose frames are numbered may end early: there the tracker found no face.
    """
    if take.fps != rate:
        detail = (
            f"the video was cut to {rate} frames a second, the tracking result has {take.fps}: "
            "correct fetch.fps, or the rate under ingest"
        )
        facts = {"value": float(take.fps), "limit": float(rate), "unit": "frames per second"}
        return "frame_rate", facts | {"detail": detail}
    if not take.numbered and len(take.motion) < n_frames - TOLERANCE:
        detail = "the tracking result is shorter than its clip, and nothing in it tells which "
        detail += "frames it lacks"
        facts = {"value": len(take.motion), "limit": n_frames, "unit": "frames"}
        return "shorter_than_clip", facts | {"detail": detail}
    return _too_long(take, n_frames)


def _too_long(take: Take, expected: float) -> tuple[str, dict] | None:
    if len(take.motion) <= expected + TOLERANCE:
        return None
    detail = "the tracking result is longer than its clip: it belongs to another cut"
    facts = {"value": len(take.motion), "limit": round(expected), "unit": "frames"}
    return "longer_than_clip", facts | {"detail": detail}


def fitted(clip, take: Take) -> Take:
    """The result at the clip's length: exactly where there is a video, else no shorter."""
    if filmed(clip):
        return take.cut(0, clip.n_frames).padded(clip.n_frames)
    return take.padded(round(_expected(clip, take) - TOLERANCE / 2))


def filmed(clip) -> bool:
    """Whether the clip has a video."""
    return pd.notna(clip.media)


def _expected(clip, take: Take) -> float:
    """Frames that the clip's seconds come to."""
    return (clip.end_s - clip.start_s) * float(take.fps)
