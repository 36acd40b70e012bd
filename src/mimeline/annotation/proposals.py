"""Names proposed for clusters, so that the workflow runs with nobody there.

A rule names an interval by how far its descriptors lie above where they rest; a cluster is named as
most of its frames' intervals are.
"""

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.annotation.resting import resting_place, resting_places
from mimeline.annotation.runs import cluster_runs, run_changes, run_means
from mimeline.vocabulary import DESCRIPTORS, NEUTRAL, series_actions, series_channels

REST_SD = 0.04  # how far faces rest apart, in coefficients
REACH_SD = 0.15  # how far they differ in what an action comes to, of its natural logarithm
DRAWS = 200  # of a rest and a reach that may be the true ones
LEAST_SURE = 0.6  # a name that is less sure is not proposed
LEAST_SHARE = 0.5  # nor one that holds for fewer of the cluster's frames


@dataclass(frozen=True)
class Rule:
    """An interval shows an action where the mean excess of its descriptors is in [least, most)."""

    action: str
    descriptors: tuple[str, ...]
    least: float
    most: float


@dataclass(frozen=True)
class Rules:
    """actions: a rule each. at_rest: the excess below which a descriptor counts as resting."""

    actions: tuple[Rule, ...]
    at_rest: float

    def rest(self, values: np.ndarray, weight: np.ndarray | None = None) -> np.ndarray:
        """(d,) where the channels rest: see `resting_place`."""
        return resting_place(values, weight)

    def unmeasured(self, region: str, channels: Sequence[str]) -> list[str]:
        """The actions of a region that none of the channels tells."""
        told = {rule.action for rule, _ in self._measured(region, channels)}
        return [action for action in series_actions(region) if action not in told]

    def classify(
        self,
        region: str,
        channels: Sequence[str],
        values: np.ndarray,
        rest: np.ndarray,
        change: np.ndarray | None = None,
    ) -> np.ndarray:
        """(n,) names: the strongest action of the region, else Neutral where all channels rest.

        None where something is high that no action is. Neutral means none of the actions that the
        channels can tell.

        channels: names of the d columns; values (n, d): single frames, or means of intervals with
        change (n, d), of `run_changes`; rest (d,): of `rest`.
        """
        change = np.zeros_like(values) if change is None else change
        names = np.array(self.names(region, channels), dtype=object)
        return names[self.codes(region, channels, values - rest, change)]

    def names(self, region: str, channels: Sequence[str]) -> list[str | None]:
        """What `codes` count: the measured actions of a region, Neutral, and None."""
        return [rule.action for rule, _ in self._measured(region, channels)] + [NEUTRAL, None]

    def codes(
        self, region: str, channels: Sequence[str], excess: np.ndarray, change: np.ndarray
    ) -> np.ndarray:
        """(n,) which of `names` each interval bears.

        excess (n, d): means less their rest; change (n, d): from an interval's first frame to its
        last. On the way to an action or back, an interval shows what is reached at its higher end,
        if half of that is its mean, as an action lasts from half of its height.
        """
        top = excess + np.abs(change) / 2  # (n, d), at the higher end
        measured = self._measured(region, channels)
        strength = np.full((len(excess), len(measured) + 1), -np.inf)  # the last: of no action
        used = np.zeros(len(channels), dtype=bool)
        for number, (rule, columns) in enumerate(measured):
            used[columns] = True
            mean, most = excess[:, columns].mean(axis=1), top[:, columns].mean(axis=1)  # (n,) each
            shown = (most >= rule.least) & (most < rule.most)
            shown &= mean >= np.maximum(self.at_rest, most / 2)
            strength[shown, number] = mean[shown]
        best, other = strength.max(axis=1), excess[:, ~used].max(axis=1, initial=-np.inf)
        acts = np.isfinite(best) & (best >= other)
        rests = (excess < np.maximum(self.at_rest, top / 2)).all(axis=1)
        neutral, none = len(measured), len(measured) + 1
        return np.select([acts, rests], [strength.argmax(axis=1), neutral], none)

    def _measured(self, region: str, channels: Sequence[str]) -> list[tuple[Rule, list[int]]]:
        """The rules of a region with the columns that tell them, where there is one."""
        descriptors = [descriptor(region, channel) for channel in channels]
        found = []
        for rule in self.actions:
            columns = [i for i, name in enumerate(descriptors) if name in rule.descriptors]
            if rule.action in series_actions(region) and columns:
                found.append((rule, columns))
        return found


def read_rules(path: Path) -> Rules:
    """The rules of resources/proposals.csv."""
    with open(path, encoding="utf-8", newline="") as file:
        rows = [
            Rule(
                row["action"],
                tuple(row["descriptors"].split()),
                float(row["min_excess"] or -np.inf),
                float(row["max_excess"] or np.inf),
            )
            for row in csv.DictReader(file)
        ]
    at_rest = next(row.most for row in rows if row.action == NEUTRAL)
    return Rules(tuple(row for row in rows if row.action != NEUTRAL), at_rest)


def descriptor(region: str, channel: str) -> str:
    """The descriptor of a region that a channel of either side is."""
    sides = (series_channels(region, side) for side in ("left", "right"))
    return next(DESCRIPTORS[region][names.index(channel)] for names in sides if channel in names)


def propose(
    region: str,
    clusters: pd.DataFrame,
    values: np.ndarray,
    channels: Sequence[str],
    rules: Rules,
) -> pd.DataFrame:
    """The `labels` rows of a region: each cluster's name and how sure it is, or why it has none.

    clusters: the `clusters` table; values (n_frames, d): the channels at its rows.
    An interval is classified alone, and what most frames are called names the cluster. Where faces
    rest and how far they go is known roughly: confidence is the share of draws of both under which
    the name stays the same.
    """
    runs = cluster_runs(clusters)
    numbers, cluster = np.unique(runs["cluster"].to_numpy("int64"), return_inverse=True)
    frames = (runs["end_frame"] - runs["start_frame"]).to_numpy()
    means, changes = run_means(runs, values), run_changes(runs, values)  # (n_runs, d) each
    names = rules.names(region, channels)
    size = np.bincount(cluster, frames)  # (K,)
    shares = np.empty((DRAWS, len(size), len(names)))  # of the frames of each cluster
    rng = np.random.default_rng(0)
    clip = pd.factorize(runs["clip_id"])[0]
    rests = resting_places(means, frames, clip, DRAWS, rng)  # (DRAWS, d)
    rests += rng.normal(0, REST_SD, rests.shape)
    for draw, rest in zip(shares, rests, strict=True):
        reach = np.exp(rng.normal(0, REACH_SD))
        code = rules.codes(region, channels, (means - rest) * reach, changes * reach)
        votes = np.bincount(cluster * len(names) + code, frames, minlength=draw.size)
        draw[:] = votes.reshape(draw.shape) / size[:, None]
    rows = []
    for number in range(len(size)):
        own = cluster == number
        level = np.average(means[own], axis=0, weights=frames[own]) - rests.mean(axis=0)  # (d,)
        highest = descriptor(region, channels[level.argmax()])
        if any(highest in rule.descriptors for rule in rules.actions):
            highest += " alone"  # without the others of its action
        rows.append(_verdict(names, shares[:, number], highest))
    found = pd.DataFrame(rows, columns=["action", "confidence", "why"])
    found["unmeasured"] = [rules.unmeasured(region, channels)] * len(found)
    found = found.assign(region=region, cluster=numbers, note=None, source="proposed")
    return found.assign(share=size / size.sum())[tables.LABELS.schema.names]


def _verdict(names, shares: np.ndarray, highest: str) -> tuple[str | None, float, str | None]:
    """A cluster's action, how sure it is, and why it has none.

    shares (DRAWS, n_names): of its frames under each draw; highest: its descriptor farthest above
    its rest.
    """
    if len(names) == 2:
        return None, np.nan, "no action of the region is measured"
    winner = shares.argmax(axis=1)
    wins = np.bincount(winner, minlength=len(names))
    first, second = np.argsort(-wins, kind="stable")[:2]
    if names[first] is None:
        return None, np.nan, f"{highest} is high, which no action is"
    if wins[first] < LEAST_SURE * len(shares):
        return None, np.nan, f"between {names[first]} and {names[second] or 'none of the actions'}"
    share = shares[winner == first].mean(axis=0)  # (n_names,)
    if share[first] < LEAST_SHARE:
        parts = np.argsort(-share, kind="stable")[:2]
        mixed = " and ".join(f"{share[i]:.0%} {names[i] or 'none of the actions'}" for i in parts)
        return None, np.nan, f"a mixture: {mixed}"
    sure = (wins[first] + 1) / (len(shares) + 2)  # what never happened in so many draws still may
    return names[first], sure, None
