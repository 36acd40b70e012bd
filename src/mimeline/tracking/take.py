"""A take: what one tracking result says, in the house's channels, signs and frame clock."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline.errors import BadFile
from mimeline.vocabulary import CHANNELS

REPROJECTION = "reprojection error of the landmarks"  # a loss that a reader works out itself
MOST_FRAMES = 1_000_000  # in a take: nine hours at 30 fps


@dataclass(frozen=True)
class Origin:
    """How a channel was had from a format.

    text: "column MouthSmileLeft", "expression through flame.npz"; of a channel that the format
    cannot give, why not. measured: whether it gives the channel. quality: what a mapping through a
    face model keeps of the channel, in [0, 1]; None where nothing was mapped, or nothing is known.
    """

    text: str
    measured: bool = True
    quality: float | None = None


@dataclass(frozen=True)
class Take:
    """motion: frame 0..n-1, valid, confidence, tracker_loss and every channel (NaN where not
    measured), one row per frame of the clock. fps: frames per second of that clock.
    coefficients: other representations, named as in tables.COEFFICIENTS, each a table with its
    columns but clip_id and frame, row by row beside motion; NaN where a frame has none.
    origins: channel → how it was had. loss: what tracker_loss is ("the tracker's own"), empty where
    there is none; no_loss: why there is none, where the reader knows.
    first_frame: the number that the source gives to its first frame, if it counts.
    numbered: the source numbers or times its frames, so that those it leaves out are known; else a
    row is a frame.
    """

    motion: pd.DataFrame
    fps: Fraction
    coefficients: Mapping[str, pd.DataFrame] = field(default_factory=dict)
    origins: Mapping[str, Origin] = field(default_factory=dict)
    loss: str = ""
    first_frame: int | None = None
    numbered: bool = False
    no_loss: str = ""

    def cut(self, start: int, end: int) -> "Take":
        """Frames [start, end), counted from 0 anew; first_frame is told of the source's own."""
        inside = self.motion["frame"].between(start, end - 1).to_numpy()
        part = self.motion[inside]
        return replace(
            self,
            motion=part.assign(frame=part["frame"] - start).reset_index(drop=True),
            coefficients={
                name: rows[inside].reset_index(drop=True)
                for name, rows in self.coefficients.items()
            },
            first_frame=None if start > 0 else self.first_frame,
        )

    def padded(self, n_frames: int) -> "Take":
        """At least n_frames frames; what the tracker did not give is not valid."""
        n_frames = max(n_frames, len(self.motion))
        return replace(
            self,
            motion=on_clock(self.motion, n_frames),
            coefficients={
                name: rows.reindex(pd.RangeIndex(n_frames))
                for name, rows in self.coefficients.items()
            },
        )

    def mirrored(self) -> "Take":
        """What a tracker says of the same pictures, mirrored: sides exchanged.

        Coefficients of face models and landmarks are left out: they have no named sides.
        """
        motion = self.motion.copy()
        for name, channel in CHANNELS.items():
            motion[channel.mirror] = channel.mirror_sign * self.motion[name]
        units = {n: rows for n, rows in self.coefficients.items() if n == "action_units"}
        origins = {CHANNELS[name].mirror: origin for name, origin in self.origins.items()}
        return replace(self, motion=motion, coefficients=units, origins=origins)


def on_clock(motion: pd.DataFrame, n_frames: int) -> pd.DataFrame:
    """One row per frame of the clock; frames without a row are not valid and hold no number."""
    motion = motion.set_index("frame").reindex(pd.RangeIndex(n_frames, name="frame"))
    motion["valid"] = motion["valid"].fillna(False).astype(bool)
    return motion.reset_index()


def assemble(
    frame: np.ndarray,
    valid: np.ndarray,
    channels: pd.DataFrame,
    confidence: np.ndarray | float,
    path: Path,
) -> pd.DataFrame:
    """Rows of a take in the motion table's columns; channels that are absent are NaN.

    frame: increasing whole numbers. Raises BadFile for a take that no memory holds.
    """
    if frame[-1] >= MOST_FRAMES:
        raise BadFile(
            path,
            found=f"frame {frame[-1]}",
            expected=f"less than {MOST_FRAMES} frames in a take",
            remedy="Mend the frame numbers or timecodes, or split the take.",
        )
    motion = channels.reindex(columns=list(CHANNELS)).astype("float32")
    motion[~np.asarray(valid)] = np.nan
    head = pd.DataFrame({"frame": frame, "valid": valid, "confidence": confidence})
    head["tracker_loss"] = np.nan
    return on_clock(pd.concat([head, motion.reset_index(drop=True)], axis=1), int(frame.max()) + 1)
