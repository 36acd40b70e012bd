"""Where a look at an exemplar helps most.

Every class of a region's track may be a cluster's right name, by a chance: what is proposed has its
confidence, the others share the rest. An answer to one interval multiplies the chances by how
likely it is under each name; "not sure" leaves them as they are.
"""

import numpy as np
import pandas as pd

from mimeline.vocabulary import NEUTRAL, series_actions

RELIABLE = 0.97  # chance that an interval shows what its cluster is best named after
TRUST = 0.8  # in a confidence: it is told by rules that may not suit a face or a tracker at all


def classes(region: str) -> tuple[str, ...]:
    """The names that a region's clusters may bear, Neutral first."""
    return (NEUTRAL, *series_actions(region))


def chances(labels: pd.DataFrame, region: str) -> np.ndarray:
    """(n_clusters, C) the chance of each of `classes(region)` to be the right name.

    labels: the region's rows of the `labels` table. Without a name or a confidence nothing is known
    of a cluster, and all names are alike.
    """
    names = classes(region)
    named = pd.Categorical(labels["action"], names).codes.astype("int64")  # (n_clusters,), -1: none
    sure = labels["confidence"].to_numpy("float64", na_value=np.nan)
    known = np.flatnonzero((named >= 0) & np.isfinite(sure))
    alike = np.full((len(labels), len(names)), 1 / len(names))
    told = alike.copy()
    told[known] = (1 - sure[known, None]) / (len(names) - 1)
    told[known, named[known]] = sure[known]
    return TRUST * told + (1 - TRUST) * alike


def after(chance: np.ndarray, answer: int) -> np.ndarray:
    """(C,) the chances of a cluster's names once one of its intervals was called by a class.

    answer: its index, negative for "not sure".
    """
    if answer < 0:
        return chance
    likelihood = np.full(len(chance), (1 - RELIABLE) / (len(chance) - 1))
    likelihood[answer] = RELIABLE
    posterior = chance * likelihood
    return posterior / posterior.sum()


def wrong(chance: np.ndarray) -> np.ndarray:
    """(...) the chance that even the best name is wrong. chance (..., C)."""
    return 1 - chance.max(axis=-1)


def worth(labels: pd.DataFrame) -> np.ndarray:
    """(n_clusters,) the share of a region's frames that would be wrong under the best name.

    labels: the `labels` table. What a person named is worth no further look; where they were not
    sure (a person's row without an action) it is worth as much as a cluster without a proposal.
    """
    found = np.zeros(len(labels))
    for region in labels["region"].unique():
        own = (labels["region"] == region).to_numpy()
        rows = labels[own]
        found[own] = rows["share"].to_numpy("float64") * wrong(chances(rows, region))
    answered = (labels["source"] == "human") & labels["action"].notna()
    return np.where(answered, 0.0, found)
