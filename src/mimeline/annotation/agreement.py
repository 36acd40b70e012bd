"""How far two persons agree on the clusters' names."""

from collections.abc import Mapping
from dataclasses import dataclass

import pandas as pd

from mimeline.annotation.label_file import RegionAnswers


@dataclass(frozen=True)
class Agreement:
    """Cohen's kappa over the clusters that both named, and over their frames; NaN where neither
    can be told. same: share of those clusters; n: how many. differing: (region, cluster)."""

    kappa: float
    kappa_frames: float
    same: float
    n: int
    differing: tuple[tuple[str, int], ...]


def agreement(
    first: Mapping[str, RegionAnswers], second: Mapping[str, RegionAnswers], labels: pd.DataFrame
) -> Agreement:
    """Between two persons' answers. labels: the `labels` table, for the clusters' shares."""
    return Agreement(float("nan"), float("nan"), float("nan"), 0, ())
