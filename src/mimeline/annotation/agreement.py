"""How far two persons agree on the clusters' names."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from mimeline.annotation.label_file import RegionAnswers
from mimeline.annotation.moving import meaning


@dataclass(frozen=True)
class Agreement:
    """Cohen's kappa over the clusters that both named, and over their frames; NaN where it is not
    defined: nothing was named by both, or both gave one and the same name to everything. same:
    share of those clusters (NaN where there are none); n: how many. differing: (region, cluster).
    """

    kappa: float
    kappa_frames: float
    same: float
    n: int
    differing: tuple[tuple[str, int], ...]


def agreement(
    first: Mapping[str, RegionAnswers], second: Mapping[str, RegionAnswers], labels: pd.DataFrame
) -> Agreement:
    """Between two persons' answers on the same fits, all regions together.

    labels: the `labels` table, for the clusters' shares. A cluster that is the same as another has
    that one's name; "not sure" is no name, and notes do not count. Answers of a region that were
    given on different fits are not compared.
    """
    both = []  # region, cluster, share, one name, the other
    for row in labels.itertuples():
        one, other = first.get(row.region), second.get(row.region)
        if one is None or other is None or one.model != other.model:
            continue
        a, b = (meaning(own.clusters, row.cluster).action for own in (one, other))
        if a and b:
            both.append((row.region, int(row.cluster), row.share, a, b))
    if not both:
        return Agreement(float("nan"), float("nan"), float("nan"), 0, ())
    found = pd.DataFrame(both, columns=["region", "cluster", "share", "one", "other"])
    differing = found[found["one"] != found["other"]]
    return Agreement(
        kappa=cohens_kappa(found["one"], found["other"], np.ones(len(found))),
        kappa_frames=cohens_kappa(found["one"], found["other"], found["share"].to_numpy()),
        same=1 - len(differing) / len(found),
        n=len(found),
        differing=tuple(zip(differing["region"], differing["cluster"], strict=True)),
    )


def cohens_kappa(one: pd.Series, other: pd.Series, weight: np.ndarray) -> float:
    """Agreement beyond chance (Cohen 1960). one, other: names of the same n things; weight (n,).

    NaN where chance alone would make them agree wholly, or nothing weighs anything.
    """
    names = sorted({*one, *other})
    table = np.zeros((len(names), len(names)))
    codes = (pd.Categorical(side, names).codes for side in (one, other))
    np.add.at(table, tuple(codes), weight)
    if not table.sum():
        return float("nan")
    table /= table.sum()
    chance = float(table.sum(axis=1) @ table.sum(axis=0))
    if np.isclose(chance, 1):
        return float("nan")
    return (float(np.trace(table)) - chance) / (1 - chance)
