"""How the variants of the ablation study do, and how they differ, with intervals over timelines."""

from collections.abc import Callable, Mapping

import numpy as np

from mimeline.annotation.scores import interval
from mimeline.evaluation.motion_scores import from_zero, spread
from mimeline.evaluation.variants import OURS
from mimeline.reporting.paired import Estimate

DISTANCES = ("var", "fid_fm", "fid_delta_fm", "snd")  # a resample's are biased, see `spread`
Draws = Mapping[str, np.ndarray]  # of each metric (1 + resamples,)


class Study:
    """The variants' scores, all on the same resamples of the same timelines.

    draws: by variant and seed, the draws of each metric. Means are over the seeds, differences are
    taken seed by seed: what two variants have in common cancels.
    """

    def __init__(self, draws: Mapping[str, Mapping[int, Draws]]):
        self.draws = draws

    def score(self, variant: str, metric: str) -> Estimate | None:
        """None where the variant or the metric has no value."""
        each = self._each(variant, metric)
        within = from_zero if metric in DISTANCES else interval
        return None if each is None else _estimate(each, within)

    def difference(self, variant: str, other: str, metric: str) -> Estimate | None:
        """Of a variant's score to another's."""
        own, others = self._each(variant, metric), self._each(other, metric)
        within = spread if metric in DISTANCES else interval
        return None if own is None or others is None else _estimate(own - others, within)

    def apart(self, variant: str, metric: str) -> Estimate | None:
        """The difference to the configured model; None of the configured model itself."""
        return None if variant == OURS else self.difference(variant, OURS, metric)

    def _each(self, variant: str, metric: str) -> np.ndarray | None:
        """(seeds, 1 + resamples)"""
        own = [draws[metric] for draws in self.draws.get(variant, {}).values() if metric in draws]
        return np.array(own) if own else None


def _estimate(each: np.ndarray, within: Callable) -> Estimate:
    """each (seeds, 1 + resamples); within: a mean's value and interval."""
    first = each[:, 0]
    return Estimate(*within(each.mean(axis=0)), float(first.min()), float(first.max()))
