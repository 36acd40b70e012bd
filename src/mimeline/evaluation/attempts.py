"""What the paper's experiments try on a region: each setting's segmentation, named by the truth."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from mimeline.annotation.proposals import Rules
from mimeline.annotation.region_series import RegionSeries
from mimeline.annotation.scores import cluster_votes
from mimeline.annotation.series import sequences
from mimeline.evaluation.annotation import by_thresholds
from mimeline.evaluation.baselines import UNTRIED, by_clap, by_hidden_markov, by_mixture
from mimeline.evaluation.descriptors import both_sides, measured_units, one_side, ruled_units
from mimeline.ticc import TICC
from mimeline.ticc.selection import along_betas
from mimeline.vocabulary import SERIES_TRACK

REFERENCE = ("reference", "configured")
BOUNDARIES = {"mask": "clips apart", "paper": "null sequences"}
JOINED = "one sequence"
NO_CLASPY = "experiments.claspy names no Python interpreter"


class LeftOut(Exception):
    """A setting that these recordings do not allow, and why."""


@dataclass(frozen=True)
class Recordings:
    """The clips that were kept.

    motion, units: tables `motion` and `action_units` · truth: clip_id, frame and truth, the
    region's true class, -1 where it does not count · sources: clip_id → source_id.
    """

    motion: pd.DataFrame
    units: pd.DataFrame
    truth: pd.DataFrame
    sources: Mapping[str, str]


@dataclass(frozen=True)
class Plan:
    """What is varied, and about what.

    configured: TICC's arguments, those of the separators too · unseen: share of the sources ·
    claspy: a Python interpreter that has it, or None.
    """

    region: str
    side: str
    configured: Mapping[str, Any]
    n_clusters: Sequence[int]
    betas: Sequence[float]
    unseen: float
    rules: Rules
    claspy: str | None


@dataclass(frozen=True)
class Attempt:
    """Settings of an experiment that are found together.

    find: seed → per setting the frames that count: clip_id, truth, found (classes, Neutral first).
    It raises LeftOut, or ValueError where the numbers are past fitting.
    seeded: whether a seed changes them.
    """

    experiment: str
    settings: tuple[str, ...]
    find: Callable[[int], Sequence[pd.DataFrame]]
    seeded: bool = True


def attempts(recordings: Recordings, plan: Plan) -> Iterator[Attempt]:
    """All of a region's. The configured setting comes first and is no other experiment's."""
    motion, region, configured = recordings.motion, plan.region, plan.configured
    own = _known(one_side(motion, region, plan.side), recordings.truth)

    def one(experiment, setting, find, seeded=True):
        return Attempt(experiment, (setting,), lambda seed: [find(seed)], seeded)

    def ticc(experiment, setting, series=own, joined=False, **changed):
        return one(experiment, setting, lambda s: _fitted(series, plan, s, changed, joined))

    yield ticc(*REFERENCE)
    for count in sorted({*plan.n_clusters} - {configured["n_clusters"]}):
        yield ticc("clusters", f"{count}", n_clusters=count)
    if betas := sorted({*map(float, plan.betas)} - {float(configured["beta"])}):
        names = tuple(f"{beta:g}" for beta in betas)
        yield Attempt("beta", names, lambda seed: _along(own, plan, seed, betas))
    for boundary, name in BOUNDARIES.items():
        if boundary != configured["boundary"]:
            yield ticc("separators", name, boundary=boundary)
    yield ticc("separators", JOINED, joined=True, boundary="mask")
    measured = _known(measured_units(recordings.units, motion, region), recordings.truth)
    ruled = _known(ruled_units(motion, region), recordings.truth)
    yield ticc("descriptors", "action units", ruled)
    yield ticc("descriptors", "measured action units", measured)
    yield ticc("sides", "both sides", _known(both_sides(motion, region), recordings.truth))
    yield one("unseen", "unseen", lambda seed: _unseen(own, recordings, plan, seed))
    yield one("baselines", "thresholds", lambda _: _by_thresholds(own, plan), seeded=False)
    yield one("baselines", "Gaussian mixture", lambda seed: _by_mixture(own, plan, seed))
    yield one("baselines", "Gaussian HMM", lambda seed: _by_hidden_markov(own, plan, seed))
    yield one("baselines", "CLaP", lambda seed: _by_clap(own, plan, seed), seeded=False)


def _known(series: RegionSeries, truth: pd.DataFrame) -> RegionSeries:
    """The series, whose frames bear the truth too."""
    frames = series.frames.merge(truth, how="left", on=["clip_id", "frame"], validate="1:1")
    return replace(series, frames=frames)


def _ticc(plan: Plan, seed: int, changed: Mapping[str, Any]) -> TICC:
    return TICC(**{**plan.configured, "seed": seed, **changed})


def _allow(series: RegionSeries, plan: Plan, changed: Mapping[str, Any]) -> None:
    """Raise LeftOut where the frames are too few or no channel moves."""
    asked = {**plan.configured, **changed}
    if reason := series.refusal(asked["n_clusters"], asked["window"]):
        raise LeftOut(reason)


def _fitted(
    series: RegionSeries, plan: Plan, seed: int, changed: Mapping[str, Any], joined: bool
) -> pd.DataFrame:
    """joined: all sequences as one, a window and a switch over their borders like any other."""
    _allow(series, plan, changed)
    X = series.values()
    lengths = np.array([len(X)]) if joined else series.lengths
    return judged(series.frames, _ticc(plan, seed, changed).fit(X, lengths).labels_, plan.region)


def _along(series: RegionSeries, plan: Plan, seed: int, betas: Sequence[float]):
    _allow(series, plan, {})
    fits = along_betas(
        lambda beta: _ticc(plan, seed, {"beta": beta}), betas, series.values(), series.lengths
    )
    return [judged(series.frames, fits[beta].labels_, plan.region) for beta in betas]


def _unseen(series: RegionSeries, recordings: Recordings, plan: Plan, seed: int) -> pd.DataFrame:
    """The clips of some sources, in clusters that were fitted and named without them."""
    own = series.frames["clip_id"].map(recordings.sources)
    sources = np.unique(own.to_numpy(str))
    count = max(round(plan.unseen * len(sources)), 1)
    if not 0 < plan.unseen < 1 or count >= len(sources):
        kept = f"{plan.unseen:g} of {len(sources)} sources"
        raise LeftOut(f"experiments.unseen leaves nothing to fit: {kept}")
    drawn = np.random.default_rng(seed).permutation(sources)[:count]
    out = own.isin(drawn).to_numpy()
    seen = replace(series, frames=series.frames[~out], lengths=sequences(series.frames[~out])[1])
    _allow(seen, plan, {})
    ticc = _ticc(plan, seed, {}).fit(seen.values(), seen.lengths)
    names = best_names(ticc.labels_, seen.frames["truth"], plan.region)
    rows, lengths = sequences(series.frames[out])
    labels = ticc.predict(rows[list(seen.channels)].to_numpy("float64"), lengths)
    return _rows(rows, names[labels])


def _by_thresholds(series: RegionSeries, plan: Plan) -> pd.DataFrame:
    if series.reason:
        raise LeftOut(series.reason)
    found, _ = by_thresholds(series.frames, plan.rules, plan.region, plan.side)
    return _rows(series.frames, found["cluster"].to_numpy())


def _by_mixture(series: RegionSeries, plan: Plan, seed: int) -> pd.DataFrame:
    _allow(series, plan, {})
    labels = by_mixture(series.values(), plan.configured["n_clusters"], seed)
    return judged(series.frames, labels, plan.region)


def _by_hidden_markov(series: RegionSeries, plan: Plan, seed: int) -> pd.DataFrame:
    _allow(series, plan, {})
    count = plan.configured["n_clusters"]
    labels = by_hidden_markov(series.values(), series.lengths, count, seed)
    return judged(series.frames, labels, plan.region)


def _by_clap(series: RegionSeries, plan: Plan, seed: int) -> pd.DataFrame:
    if plan.claspy is None:
        raise LeftOut(NO_CLASPY)
    _allow(series, plan, {})
    labels = by_clap(series.values(), series.lengths, plan.claspy, seed)
    tried = labels != UNTRIED
    return judged(series.frames[tried], labels[tried], plan.region)


def judged(frames: pd.DataFrame, labels: np.ndarray, region: str) -> pd.DataFrame:
    """Frames with each cluster's best name. frames: of `Recordings`; labels (n_frames,)."""
    return _rows(frames, best_names(labels, frames["truth"], region)[labels])


def best_names(labels, codes, region: str) -> np.ndarray:
    """(K,) the class that most frames of each cluster have in truth.

    labels, codes (n_frames,); codes of -1 do not count. A cluster without a frame that counts is
    Neutral.
    """
    codes = np.asarray(codes)
    return cluster_votes(labels, codes, labels.max() + 1, SERIES_TRACK[region]).argmax(axis=1)


def _rows(frames: pd.DataFrame, found: np.ndarray) -> pd.DataFrame:
    rows = frames[["clip_id", "truth"]].assign(found=found)
    return rows[rows["truth"] >= 0]
