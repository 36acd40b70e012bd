"""A picture of a clip that was never cut: a frame out of its middle, from its source."""

import logging
import tempfile
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.clips.catalogues.folder import lies_in
from mimeline.clips.piece import SIDES, Piece
from mimeline.clips.source import local_videos
from mimeline.errors import MimelineError
from mimeline.media.cut import cut
from mimeline.media.frames import read_frames
from mimeline.media.limits import Limits
from mimeline.media.probe import probe

log = logging.getLogger(__name__)

WAIT_S = 30.0  # for a source to be looked into, or a frame to be cut
COLUMNS = ["clip_id", "source_id", "start_s", "end_s", "video"]
COLUMNS += [f"bbox_{side}" for side in SIDES]


@dataclass(frozen=True)
class Still:
    """Where the picture of a clip is to be had: clip is its row, is_cut as for a Piece."""

    clip: Any
    source: Path
    is_cut: bool
    limits: Limits

    def picture(self) -> np.ndarray | None:
        """The frame (H, W, 3) uint8 RGB, cropped to the clip's box; None if there is none."""
        piece = Piece(self.clip, Fraction(1), None, is_cut=self.is_cut)
        try:
            video = probe(self.source, self.limits)
            end_s = min(piece.start_s + piece.length_s, video.duration_s)
            with tempfile.TemporaryDirectory() as folder:
                film = Path(folder) / "frame.mp4"
                cut(
                    self.source,
                    video,
                    film,
                    start_s=(piece.start_s + end_s) / 2,  # of what there is
                    n_frames=1,
                    fps=video.rate,
                    box=piece.box(video),
                    side_px=None,
                    limits=self.limits,
                )
                return next(read_frames(film, [0]))[1]
        except MimelineError as error:
            log.debug("%s has no picture: %s", self.clip.clip_id, error)
            return None


def stills(
    clips: Sequence[str | Path],
    data: str | Path,
    wanted: Collection[str],
    folder: str | None,
    max_pixels: int,
    max_source_s: float,
    max_mb: float,
    timeout_s: float,
) -> dict[str, Still]:
    """Clip → its still, of the wanted clips whose source lies here.

    clips: `clips` tables of the catalogue. data, folder, max_pixels, max_source_s, max_mb,
    timeout_s: where sources lie and what they may ask, as for `fetch`; a picture waits no longer
    than WAIT_S for either.
    """
    limits = Limits(max_pixels, max_source_s, max_mb, min(timeout_s, WAIT_S))
    rows = tables.read_all(tables.CLIPS, clips, COLUMNS)
    rows = rows[rows["clip_id"].isin(wanted)]
    return {
        clip.clip_id: Still(clip, path, is_cut, limits)
        for clip, path, is_cut in local_videos(rows, Path(data), folder)
        if path is not None and (pd.isna(clip.video) or lies_in(path, Path(data)))
    }
