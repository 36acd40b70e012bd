"""The motion of one clip, outside any run: its frames, and what is to be known of them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np
import pandas as pd

from mimeline.timeline.timeline import Timeline
from mimeline.tracking.take import Origin, Take, assemble
from mimeline.vocabulary import CHANNELS


@dataclass(frozen=True, eq=False)
class Motion:
    """frames: frame 0..n-1, valid, confidence, tracker_loss and every channel, a row for each; a
    channel is NaN where it was neither measured nor made.

    fps: frames per second. origins: channel → how it was had, and how far it may be relied on.
    timeline: what its face was asked to do, or was seen to. made: how it came about, plain values
    ("model", "seed"); empty for a recording.
    """

    frames: pd.DataFrame
    fps: Fraction
    origins: Mapping[str, Origin] = field(default_factory=dict)
    timeline: Timeline | None = None
    made: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def of_take(cls, take: Take) -> "Motion":
        """The motion of a tracking result."""
        return cls(take.motion, take.fps, take.origins)

    @classmethod
    def of_channels(
        cls,
        values: np.ndarray,
        channels: tuple[str, ...],
        fps: Fraction,
        origins: Mapping[str, Origin],
        timeline: Timeline | None,
        made: Mapping[str, Any],
    ) -> "Motion":
        """What a model made: values (n, D), a column for each of the channels, in their units."""
        table = pd.DataFrame(values, columns=list(channels))
        n = np.arange(len(table))
        frames = assemble(n, np.ones(len(table), bool), table, np.nan, "motion")
        return cls(frames, fps, origins, timeline, made)

    def __len__(self) -> int:
        return len(self.frames)

    @property
    def seconds(self) -> float:
        """How long it lasts."""
        return float(len(self) / self.fps)

    @property
    def moved(self) -> list[str]:
        """The channels that hold a number in some frame, in the order of the vocabulary."""
        holds = self.frames[list(CHANNELS)].notna().any()
        return [channel for channel in CHANNELS if holds[channel]]
