"""What a data set holds, counted while it is written: what its card tells."""

from collections import Counter
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np
import pandas as pd

from mimeline.dataset.split import PARTS
from mimeline.exchange.finished import Shard
from mimeline.vocabulary import ACTIONS, CHANNELS


@dataclass(frozen=True)
class Part:
    """people: of those that the catalogue names; unnamed: clips of which it names nobody."""

    name: str
    clips: int
    frames: int
    seconds: float
    sources: int
    people: int
    unnamed: int


@dataclass(frozen=True)
class Shown:
    """An action: share of the frames in which it is known whether it is shown (NaN: in none)."""

    name: str
    share: float
    known: int
    intervals: int
    clips: int


@dataclass
class Contents:
    """Counts of the clips that were added."""

    _clips: list[pd.DataFrame] = field(default_factory=list)
    _frames: int = 0
    _valid: int = 0
    _shown: Counter = field(default_factory=Counter)
    _known: Counter = field(default_factory=Counter)
    _intervals: Counter = field(default_factory=Counter)
    _showing: Counter = field(default_factory=Counter)
    _having: Counter = field(default_factory=Counter)

    def add(self, shard: Shard) -> None:
        """Count the clips of a shard. No clip is added twice."""
        self._clips.append(shard.clips)
        valid = shard.motion["valid"].to_numpy(bool)
        self._frames += len(valid)
        self._valid += int(valid.sum())
        for name in CHANNELS:
            self._having[name] += int(np.isfinite(shard.motion[name].to_numpy()[valid]).sum())
        for name in ACTIONS:
            self._known[name] += int(shard.frames[name].notna().sum())
            self._shown[name] += int(shard.frames[name].sum())
        own = shard.intervals.groupby("action")["clip_id"]
        self._intervals.update(own.size().to_dict())
        self._showing.update(own.nunique().to_dict())

    @property
    def clips(self) -> pd.DataFrame:
        return pd.concat(self._clips, ignore_index=True)

    @property
    def parts(self) -> list[Part]:
        """Each part, those without a clip too, and all of them at the end."""
        clips = self.clips
        own = [(name, clips[clips["part"] == name]) for name in PARTS]
        return [_part(name, rows) for name, rows in [*own, ("all", clips)]]

    @property
    def rates(self) -> list[Fraction]:
        """Frame rates, the commonest first."""
        told = zip(self.clips["fps_num"], self.clips["fps_den"], strict=True)
        return [fps for fps, _ in Counter(Fraction(int(n), int(d)) for n, d in told).most_common()]

    @property
    def valid(self) -> float:
        """Share of the frames in which the tracker has the face."""
        return self._valid / self._frames if self._frames else 0.0

    @property
    def actions(self) -> list[Shown]:
        """Each action, in the vocabulary's order."""
        return [
            Shown(
                name,
                self._shown[name] / self._known[name] if self._known[name] else float("nan"),
                self._known[name],
                self._intervals[name],
                self._showing[name],
            )
            for name in ACTIONS
        ]

    def having(self, channel: str) -> float:
        """Share of the valid frames that have a channel."""
        return self._having[channel] / self._valid if self._valid else 0.0


def _part(name: str, clips: pd.DataFrame) -> Part:
    seconds = clips["n_frames"] * clips["fps_den"] / clips["fps_num"]
    return Part(
        name,
        len(clips),
        int(clips["n_frames"].sum()),
        float(seconds.sum()),
        clips["source_id"].nunique(),
        clips["subject_id"].nunique(),
        int(clips["subject_id"].isna().sum()),
    )
