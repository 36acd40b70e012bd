"""What films are cut out of; a video that lies here."""

import os
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from mimeline.clips.catalogues.folder import lies_in
from mimeline.clips.catalogues.videos import videos_in
from mimeline.errors import BadFile, MimelineError, unreadable
from mimeline.media.limits import Limits, check_bytes
from mimeline.media.probe import Probe, probe


def local_videos(clips: pd.DataFrame, data: Path, folder: str | None) -> Iterator[tuple]:
    """Each clip with the path of its video, None if there is none here, and whether that is cut.

    clips: rows of `clips`. A clip's video is the one that the catalogue names, wherever that leads;
    else <data>/<folder>/<clip_id>.mp4, the clip itself, cut already; else <source_id>.mp4 there.
    """
    unnamed = clips["video"].isna().any()
    videos = videos_in(data / folder) if folder is not None and unnamed else {}
    for clip in clips.itertuples():
        if isinstance(clip.video, str):
            yield clip, data / clip.video, False
        else:
            own = videos.get(clip.clip_id)
            yield clip, own or videos.get(clip.source_id), own is not None


class Footage(NamedTuple):
    """A file with a clip's seconds. whole_s: length of the video that it is, or is part of."""

    path: Path
    video: Probe
    whole_s: float


class LocalSource:
    """A video file; it is looked into once, when the first clip is to be cut out of it.

    within: a folder that its path must lead into by its names; None: anywhere. Links are followed
    wherever they lead: they are the user's.
    """

    lasting = False  # to find out again why a clip cannot be cut costs nothing

    def __init__(self, path: Path, limits: Limits, *, within: Path | None = None):
        self.path, self.name, self.limits, self.within = path, path, limits, within
        self._video: Probe | MimelineError | None = None

    def key(self) -> dict:
        """What tells that it is the same video. Raises BadFile or Refused."""
        status = self._status()
        check_bytes(self.path, status.st_size, self.limits)
        name, size, time = self.path.name, status.st_size, status.st_mtime_ns
        return {"source": name, "size": size, "mtime_ns": time}

    def stamp(self) -> None:
        """The key tells all."""

    def footage(self, since_s: float, until_s: float) -> Footage:
        """The video, whatever seconds are asked for. Raises what `probe` raises."""
        if self._video is None:
            try:
                self._video = probe(self.path, self.limits)
            except MimelineError as error:
                self._video = error
        if isinstance(self._video, MimelineError):
            raise self._video
        return Footage(self.path, self._video, self._video.duration_s)

    def close(self, *, settled: bool) -> None:
        """All clips are done."""

    def _status(self) -> os.stat_result:
        if self.within is not None and not lies_in(self.path, self.within):
            raise BadFile(
                self.path,
                found="a path that leads out of data_dir",
                expected="a video below it",
                remedy="Name a video below it, or link to it from there.",
            )
        try:
            return self.path.stat()
        except OSError as error:
            remedy = "Take the video again, or mend the link to it."
            raise unreadable(self.path, error, expected="a video", remedy=remedy) from error
