"""Names proposed for clusters, so that the workflow runs with nobody there."""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mimeline.vocabulary import DESCRIPTORS, NEUTRAL, series_actions


@dataclass(frozen=True)
class Proposal:
    """An action is proposed for a mean excess of its descriptors in [least, most)."""

    action: str
    descriptors: tuple[str, ...]
    least: float
    most: float


def read_proposals(path: Path) -> list[Proposal]:
    """The rules of resources/proposals.csv."""
    with open(path, encoding="utf-8", newline="") as file:
        return [
            Proposal(
                row["action"],
                tuple(row["descriptors"].split()),
                float(row["min_excess"]),
                float(row["max_excess"] or np.inf),
            )
            for row in csv.DictReader(file)
        ]


def propose(
    region: str, values: np.ndarray, clusters: np.ndarray, rules: list[Proposal]
) -> dict[int, str]:
    """An action for each cluster.

    values (T, n): the region's descriptors, in DESCRIPTORS order; clusters (T,).
    A descriptor's rest is its 25 % quantile, since faces are at rest most of the time; the action
    whose descriptors exceed their rest most, and enough, names the cluster, else it is Neutral.
    """
    rest = np.quantile(values, 0.25, axis=0)
    names = {}
    for cluster in np.unique(clusters):
        excess = dict(
            zip(DESCRIPTORS[region], values[clusters == cluster].mean(axis=0) - rest, strict=True)
        )
        strength = {
            rule.action: mean
            for rule in rules
            if rule.action in series_actions(region)
            and rule.least <= (mean := np.mean([excess[d] for d in rule.descriptors])) < rule.most
        }
        names[int(cluster)] = max(strength, key=strength.get, default=NEUTRAL)
    return names
