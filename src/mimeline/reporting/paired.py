"""Scores of settings on the same clips, and their differences, with intervals over these clips."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from mimeline.annotation.scores import macro_f1, resampled
from mimeline.vocabulary import NEUTRAL, series_actions

Key = tuple[str, str]  # experiment, setting
QUANTILES = (0.025, 0.975)


@dataclass(frozen=True)
class Estimate:
    """A number, its 95 % interval over clips, and how far it goes over the seeds."""

    value: float
    low: float
    high: float
    least: float
    most: float

    @property
    def tie(self) -> bool:
        """Of a difference: whether it may be none, as it may where there is no interval."""
        return not (self.low > 0 or self.high < 0)

    @classmethod
    def of(cls, draws: np.ndarray) -> "Estimate":
        """draws (seeds, 1 + resamples): the first of each is on the clips as they are."""
        mean = draws.mean(axis=0)  # (1 + resamples,)
        low, high = (float(q) for q in np.nanquantile(mean[1:], QUANTILES))
        each = draws[:, 0]
        return cls(float(mean[0]), low, high, float(each.min()), float(each.max()))


class Compared:
    """The settings of a region.

    counts: by setting and seed (n_clips, C, C) frames, truth in rows; all of the same clips.
    Resamples of clips are drawn once: what two settings have in common cancels in a difference.
    """

    def __init__(self, rows: pd.DataFrame, region: str, resamples: int, seed: int):
        """rows: of the `experiments` table, this region's."""
        clips, clip = np.unique(rows["clip_id"].to_numpy(str), return_inverse=True)
        names = [NEUTRAL, *series_actions(region)]
        shape = (len(clips), len(names), len(names))
        place = [pd.Categorical(rows[column], names).codes for column in ("truth", "found")]
        self.counts: dict[Key, dict[int, np.ndarray]] = {}
        for key, own in rows.groupby(["experiment", "setting", "seed"]).indices.items():
            counts = np.zeros(shape)
            counts[clip[own], place[0][own], place[1][own]] = rows["frames"].to_numpy()[own]
            self.counts.setdefault(key[:2], {})[int(key[2])] = counts
        self._known: dict[Key | tuple[Key, Key], Estimate] = {}  # what was asked before
        self._weights = resampled(len(clips), resamples, np.random.default_rng(seed))

    def frames(self, key: Key) -> int:
        """How many frames a setting is judged by, over the seeds the most."""
        return max(int(counts.sum()) for counts in self.counts[key].values())

    def score(self, key: Key, like: Key | None = None) -> Estimate:
        """Macro-F1, mean over the seeds. like: on the clips of that setting alone."""
        if like is None:
            return self._known.get(key) or self._known.setdefault(key, self._score(key))
        pairs = self._pairs(key, like)
        return Estimate.of(np.array([self._f1(own, _both(own, other)) for own, other in pairs]))

    def difference(self, key: Key, other: Key) -> Estimate:
        """Macro-F1 of one less that of another, on the clips that both have.

        Seed by seed where both have the same, else each with each.
        """
        pair = (key, other)
        return self._known.get(pair) or self._known.setdefault(pair, self._difference(*pair))

    def _score(self, key: Key) -> Estimate:
        return Estimate.of(np.array([self._f1(c) for c in self.counts[key].values()]))

    def _difference(self, key: Key, other: Key) -> Estimate:
        draws = []
        for first, second in self._pairs(key, other):
            both = _both(first, second)
            draws.append(self._f1(first, both) - self._f1(second, both))
        return Estimate.of(np.array(draws))

    def _pairs(self, key: Key, other: Key) -> list[tuple[np.ndarray, np.ndarray]]:
        own, others = self.counts[key], self.counts[other]
        if own.keys() == others.keys():
            return [(own[seed], others[seed]) for seed in own]
        return [(first, second) for first in own.values() for second in others.values()]

    def _f1(self, counts: np.ndarray, clips=slice(None)) -> np.ndarray:
        """(1 + resamples,); NaN where none of the clips was drawn."""
        cells = counts[clips].reshape(-1, counts.shape[1] * counts.shape[2])
        drawn = (self._weights[:, clips] @ cells).reshape(-1, *counts.shape[1:])
        return np.where(drawn.any(axis=(1, 2)), macro_f1(drawn), np.nan)


def _both(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """(n_clips,) bool"""
    return first.any(axis=(1, 2)) & second.any(axis=(1, 2))


def compared(tables: Mapping[str, pd.DataFrame], resamples: int, seed: int) -> dict[str, Compared]:
    """By region; one without rows is left out."""
    return {
        region: Compared(rows.reset_index(drop=True), region, resamples, seed)
        for region, rows in tables.items()
        if len(rows)
    }
