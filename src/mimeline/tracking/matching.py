"""A clip's take: its own result or its seconds of its source's, at the clip's length."""

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import pandas as pd

from mimeline.errors import NoSuchFile
from mimeline.tracking.readers import Tracker
from mimeline.tracking.take import Take

TOLERANCE = 2.0  # frames: catalogues round seconds to 1/100, trackers skip a first or last frame


def take_of(clip, tracker: Tracker, read: Callable[[Path], Take]) -> Take:
    """The clip's own result, else its seconds of its source's result, as long as the tracker says.

    clip: a row of `clips`. read: reads a result. Raises MimelineError where it cannot be read,
    NoSuchFile where there is none.
    """
    if own := tracker.result(clip.clip_id):
        return read(own)
    if whole := tracker.result(clip.source_id):
        take = read(whole)
        return take.cut(round(clip.start_s * take.fps), round(clip.end_s * take.fps))
    raise NoSuchFile(
        tracker.folder / clip.clip_id,
        found="no such file or folder",
        expected=f"a {tracker.reader.convention.title} of the clip or of {clip.source_id}",
        remedy="Check data_dir and the folder in the ingest section.",
    )


def of_another_cut(clip, take: Take) -> tuple[str, dict] | None:
    """Rule and facts where the result cannot be that of the clip: another rate, or too long."""
    if filmed(clip) and take.fps != (rate := Fraction(int(clip.fps_num), int(clip.fps_den))):
        detail = (
            f"the video was cut to {rate} frames a second, the tracking result has {take.fps}: "
        )
        detail += "correct fetch.fps, or the rate under ingest"
        facts = {"value": float(take.fps), "limit": float(rate), "unit": "frames per second"}
        return "frame_rate", facts | {"detail": detail}
    expected = _expected(clip, take)
    if len(take.motion) > expected + TOLERANCE:
        detail = "the tracking result is longer than its clip: it belongs to another cut"
        facts = {"value": len(take.motion), "limit": round(expected), "unit": "frames"}
        return "longer_than_clip", facts | {"detail": detail}
    return None


def fitted(clip, take: Take) -> Take:
    """The result at the clip's length: exactly where there is a video, else no shorter."""
    if filmed(clip):
        return take.cut(0, clip.n_frames).padded(clip.n_frames)
    return take.padded(round(_expected(clip, take) - TOLERANCE / 2))


def filmed(clip) -> bool:
    """Whether the clip has a video."""
    return pd.notna(clip.media)


def _expected(clip, take: Take) -> float:
    """Frames that the clip ought to have: those of its video, else what its seconds come to."""
    return clip.n_frames if filmed(clip) else (clip.end_s - clip.start_s) * float(take.fps)
