"""Pictures of clips for the page: frames of their films, else their motion on a drawn face.

A clip that was never cut, nor tracked, has one still out of its source, whichever frame is asked
for.

The page's parts ask for the frames that they show; then each video is opened once and each frame
drawn once.
"""

import base64
import logging
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.errors import MimelineError
from mimeline.media.frames import read_frames
from mimeline.media.picture import encode
from mimeline.reporting.filmstrip import Place
from mimeline.reporting.stand_in import StandIn
from mimeline.reporting.stills import Still
from mimeline.vocabulary import CHANNELS

log = logging.getLogger(__name__)

SIZE = 112  # pixels of a small picture's edge: twice what it is shown at
FREE = (43, 41, 38)  # beside a picture that is not square


@dataclass(frozen=True)
class Shot:
    """A frame of a clip that the page wants to show, size pixels wide and high.

    frame: None is the middle of a clip whose frames were never counted.
    region: a series region, which is drawn close, filmed or not; None: the whole head.
    """

    clip_id: str
    frame: int | None
    size: int
    region: str | None


@dataclass(frozen=True)
class Picture:
    """filmed: a frame of the clip's video; else the clip's motion drawn."""

    uri: str
    filmed: bool

    @property
    def origin(self) -> str:
        return "filmed" if self.filmed else "drawn"


class Album:
    """Collects shots, then has their pictures.

    media: clip → video, at the clip's own rate. motions: `motion` tables of the clips.
    stills: clip → its source's, of clips without film and motion.
    gone: clip → why its video could not be read, once developed.
    """

    def __init__(
        self,
        media: Mapping[str, Path],
        motions: Sequence[str | Path],
        stand_in: StandIn,
        stills: Mapping[str, Still] | None = None,
    ):
        self.media, self.motions, self.stand_in = media, motions, stand_in
        self.stills = stills or {}
        self.gone: dict[str, str] = {}
        self._shots: dict[str, set[Shot]] = defaultdict(set)
        self._pictures: dict[Shot, Picture] = {}

    def ask(
        self, clip_id: str, frame: int | None, size: int = SIZE, region: str | None = None
    ) -> Shot:
        """A picture is wanted; whether there is one shows when all are developed."""
        shot = Shot(clip_id, None if frame is None else int(frame), size, region)
        self._shots[clip_id].add(shot)
        return shot

    def get(self, shot: Shot | None) -> Picture | None:
        """The picture, or None: no video, and no motion measured in that frame."""
        return self._pictures.get(shot) if shot else None

    def found(self, wanted: Iterable[tuple[Place, Shot]]) -> list[tuple[Place, Picture]]:
        """Of a strip, the places for which there is a picture."""
        return [(place, self._pictures[shot]) for place, shot in wanted if shot in self._pictures]

    def any(self, shots: Iterable[Shot]) -> bool:
        return any(shot in self._pictures for shot in shots)

    def filmed(self) -> bool:
        return any(picture.filmed for picture in self._pictures.values())

    def drawn(self) -> bool:
        return any(not picture.filmed for picture in self._pictures.values())

    def develop(self) -> None:
        """Make every picture that was asked for, where that is possible."""
        for clip_id in self.media.keys() & self._shots.keys():
            self._film(clip_id, self._shots[clip_id])
        for clip_id, own in self._shots.items():
            self._copy(clip_id, [shot for shot in own if shot.frame is None])
        open_shots = {
            shot
            for own in self._shots.values()
            for shot in own
            if shot.frame is not None and shot not in self._pictures
        }
        if open_shots:
            for path in self.motions:
                self._draw(path, open_shots)
        filmed = sum(picture.filmed for picture in self._pictures.values())
        log.info("%d frames of videos, %d drawn", filmed, len(self._pictures) - filmed)

    def _film(self, clip_id: str, shots: Iterable[Shot]) -> None:
        wanted: dict[int, list[Shot]] = defaultdict(list)
        for shot in shots:
            if shot.region is None:
                wanted[shot.frame].append(shot)
        filmed = {}
        try:
            for number, frame in read_frames(self.media[clip_id], wanted):
                for shot in wanted[number]:
                    picture = square(frame, shot.size)
                    filmed[shot] = Picture(data_uri(picture), filmed=True)
        except MimelineError as error:
            self.gone[clip_id] = str(error)
            log.warning("%s is drawn, its video cannot be shown: %s", clip_id, error)
        else:
            self._pictures |= filmed

    def _copy(self, clip_id: str, shots: Sequence[Shot]) -> None:
        frame = self.stills[clip_id].picture() if shots else None
        if frame is not None:
            for shot in shots:
                self._pictures[shot] = Picture(data_uri(square(frame, shot.size)), filmed=True)

    def _draw(self, path: str | Path, shots: set[Shot]) -> None:
        wanted = pd.DataFrame(
            [(shot.clip_id, shot.frame, (shot.size, shot.region), shot) for shot in shots],
            columns=["clip_id", "frame", "view", "shot"],
        )
        rows = tables.read(tables.MOTION, path, ["clip_id", "frame", "valid", *CHANNELS])
        rows = rows[rows["valid"] & rows["clip_id"].isin(wanted["clip_id"])]
        rows = rows.merge(wanted, on=["clip_id", "frame"])
        for view, same in rows.groupby("view", sort=False):
            drawn = self.stand_in.pictures(same, *view)
            for shot, picture in zip(same["shot"], drawn, strict=True):
                self._pictures[shot] = Picture(data_uri(picture), filmed=False)


def data_uri(picture: np.ndarray) -> str:
    """A picture (H, W, 3) uint8 RGB as an address that holds it."""
    return "data:image/webp;base64," + base64.b64encode(encode(picture, "webp")).decode()


def square(frame: np.ndarray, size: int) -> np.ndarray:
    """The whole picture, size pixels wide and high; what its shape leaves free is dark."""
    height, width = frame.shape[:2]
    scale = size / max(height, width)
    high, wide = max(1, round(scale * height)), max(1, round(scale * width))
    way = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
    fitted = np.full((size, size, 3), FREE, np.uint8)
    top, left = (size - high) // 2, (size - wide) // 2
    fitted[top : top + high, left : left + wide] = cv2.resize(
        frame, (wide, high), interpolation=way
    )
    return fitted
