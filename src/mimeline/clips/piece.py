"""What is to be cut for a clip."""

import math
from fractions import Fraction

import numpy as np

from mimeline.clips.admission import LARGEST_SHARE
from mimeline.media.box import Box
from mimeline.media.limits import Limits, Refused
from mimeline.media.probe import Probe

SIDES = ("top", "bottom", "left", "right")


class Piece:
    """A clip's seconds and the part of the picture, of whatever video it lies in.

    clip: a row of the `clips` table. fps: frames per second, exactly. side_px: edge of a square
    picture, or None. is_cut: the video is the clip itself.
    """

    def __init__(self, clip, fps: Fraction, side_px: int | None, *, is_cut: bool):
        self.clip_id, self.fps, self.side_px = clip.clip_id, fps, side_px
        self.start_s = 0.0 if is_cut else clip.start_s
        self.length_s = clip.end_s - clip.start_s
        edges = [float(getattr(clip, f"bbox_{side}")) for side in SIDES]
        self.edges = None if is_cut or not np.isfinite(edges).all() else edges

    @property
    def n_frames(self) -> int:
        return max(1, round(self.length_s * self.fps))

    def key(self) -> dict:
        """All of the piece that its film depends on."""
        return {
            "start_s": self.start_s,
            "n_frames": self.n_frames,
            "fps": str(self.fps),
            "edges": self.edges,
            "side_px": self.side_px,
        }

    def check_length(self, limits: Limits) -> None:
        """Raises Refused if the catalogue asks for more than a source may have."""
        if math.isfinite(self.length_s) and self.length_s <= limits.max_source_s:
            return
        raise Refused(
            self.clip_id,
            rule="too_long",
            value=self.length_s,
            limit=limits.max_source_s,
            unit="s",
            found=f"a clip of {self.length_s:g} s",
            expected=f"at most {limits.max_source_s:g} s",
            remedy="Check the catalogue's times, or raise fetch.max_source_s.",
        )

    def box(self, video: Probe) -> Box:
        """The part of the picture in pixels; the table has pixels, or shares of the picture.

        Raises Refused if it lies wholly outside the picture.
        """
        if self.edges is None:
            return Box.whole(video.width, video.height)
        if max(self.edges) <= LARGEST_SHARE:
            box = Box.of_shares(*self.edges, video.width, video.height)
        else:
            box = Box(*self.edges)
        *_, width, height = box.within(video.width, video.height)
        if not width or not height:
            outside = max(-box.bottom, -box.right, box.top - video.height, box.left - video.width)
            raise Refused(
                self.clip_id,
                rule="box_outside",
                value=max(outside, 0.0),
                limit=0.0,
                unit="px",
                found=f"a box that holds nothing of the {video.width} x {video.height} picture",
                expected="one that lies in it",
                remedy="Check the catalogue's box and whose picture it was drawn on.",
            )
        return box
