"""How right the annotation is, against a truth that somebody planted or wrote down."""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.annotation.annotate import annotate_frames, unmeasured_actions
from mimeline.annotation.proposals import Rules, read_rules
from mimeline.annotation.queries import classes
from mimeline.annotation.scores import (
    Judged,
    cluster_votes,
    confusion_counts,
    interval,
    judged,
    of_region,
    region_draws,
    resampled,
    true_codes,
)
from mimeline.annotation.segment_scores import segment_counts, segment_draws
from mimeline.annotation.series import dead_channels, sequences
from mimeline.annotation.thresholds import Limits
from mimeline.annotation.timelines import read_truth
from mimeline.evaluation.baselines import by_mixture
from mimeline.vocabulary import NEUTRAL, SERIES_TRACK, series_channels, track_actions

log = logging.getLogger(__name__)


def evaluate_annotation(
    clips: Sequence[Path],
    ledgers: Sequence[Path],
    motions: Sequence[Path],
    frames: Sequence[Path],
    series: dict[str, Path],
    clusters: dict[str, Path],
    rules: Path,
    truth: Path | None,
    metrics: Path,
    confusion: Path,
    side: str,
    annotate: dict,
    gmm_components: int,
    overlap: float,
    resamples: int,
    seed: int,
) -> None:
    """Score the annotation per region, with 95 % intervals over clips (docs/scores.md).

    metrics: macro-F1 of frames (Ma et al. 2025, 4.1), precision and recall of intervals and the
    errors of their edges in frames; confusion: what each true action was found to be. All of a
    variant's intervals come from the same resamples of clips.

    Variants: "named" is what annotate wrote; "oracle" gives each cluster the name that most of its
    frames have in truth: no other names are right on more frames, though on macro-F1 others may be
    better; "gmm" does so for a Gaussian mixture on single frames, whose intervals may be as short
    as they come; "thresholds" names each frame alone by the rules that clusters are proposed names
    by (the paper's other way, section 2).
    rules: resources/proposals.csv. truth: of `read_truth`, which takes ledgers too, those of the
    stages before; None: then the tables are empty.
    overlap: least intersection over union of an interval that counts as found.
    """
    if truth is None:
        reason = "no truth is known for these recordings"
        tables.write(tables.METRICS, tables.empty(tables.METRICS), metrics, reason)
        tables.write(tables.CONFUSION, tables.empty(tables.CONFUSION), confusion, reason)
        return
    owned = tables.read_all(tables.CLIPS, clips)
    true = read_truth(truth, owned, tables.read_all(tables.LEDGER, ledgers))
    kept = owned["clip_id"]
    motion = tables.read_all(tables.MOTION, motions)
    motion = motion[motion["clip_id"].isin(kept)].reset_index(drop=True)

    ticc, mixture, alone = {}, {}, {}
    for region in series:
        assigned = tables.read(tables.CLUSTERS, clusters[region])
        if assigned.empty:
            continue
        ticc[region] = assigned
        points, _ = sequences(tables.read(tables.SERIES[region, side], series[region]))
        X = points[list(series_channels(region, side))].to_numpy("float64")
        component = by_mixture(X, gmm_components, seed)
        mixture[region] = points[["clip_id", "frame"]].assign(cluster=component, margin=0.0)
        alone[region] = by_thresholds(points, read_rules(rules), region, side)

    limits = Limits(**annotate)
    variants = {"named": tables.read_all(tables.FRAMES, frames)}
    for name, assigned in (("oracle", ticc), ("gmm", mixture)):
        names = [oracle(true, rows, region) for region, rows in assigned.items()]
        labels = pd.concat(names) if names else tables.empty(tables.LABELS)
        shortest = limits if name == "oracle" else replace(limits, min_frames=1)
        variants[name] = annotate_frames(motion, assigned, labels, shortest)
    singly = {region: clusters for region, (clusters, _) in alone.items()}
    labels = pd.concat([labels for _, labels in alone.values()] or [tables.empty(tables.LABELS)])
    variants["thresholds"] = annotate_frames(motion, singly, labels, limits)

    rows, shares = [], []
    for variant, predicted in variants.items():
        tracks = judged(true, predicted)
        if not tracks:
            continue
        n_clips = next(iter(tracks.values())).n_clips
        weights = resampled(n_clips, resamples, np.random.default_rng(seed))
        scored = scores(tracks, overlap, weights)
        rows += [("annotation", variant, "all", *row, seed) for row in scored]
        shares += [(variant, *row) for row in confusion_shares(tracks, weights)]
        told = [f"{name} {value:.3f}" for name, value, *_ in scored if name.startswith("f1_")]
        log.info("%s: %s", variant, ", ".join(told))
    reason = "" if rows else "truth and annotation measure no frame in common"
    for table, found, path in (
        (tables.METRICS, rows, metrics),
        (tables.CONFUSION, shares, confusion),
    ):
        tables.write(table, pd.DataFrame(found, columns=table.schema.names), path, reason)


def scores(tracks: Mapping[str, Judged], overlap: float, weights: np.ndarray) -> list[tuple]:
    """(metric, value, low, high, n) of every score that has a value, region by region.

    n: the frames, intervals or edges that it is of. weights: of `resampled`.
    """
    counts = confusion_counts(tracks)
    segments = segment_draws(segment_counts(tracks, overlap), weights)
    rows = []
    for region, f1 in region_draws(counts, weights).items():
        frames = max(int(own.sum()) for own in of_region(region, counts))
        rows.append((f"f1_{region}", *interval(f1), frames))
        rows += [
            (f"{name}_{region}", *interval(own.values), own.n)
            for name, own in segments[region].items()
        ]
    return [row for row in rows if np.isfinite(row[1])]


def confusion_shares(tracks: Mapping[str, Judged], weights: np.ndarray) -> list[tuple]:
    """(track, truth, found, frames, share, low, high) for each class that truth shows.

    share: of the frames of that truth. weights: of `resampled`.
    """
    rows = []
    for track, counts in confusion_counts(tracks).items():
        drawn = np.tensordot(weights, counts, 1)  # (1 + resamples, C, C)
        of_truth = drawn.sum(axis=2, keepdims=True)
        share = np.divide(drawn, of_truth, out=np.full(drawn.shape, np.nan), where=of_truth > 0)
        names = [NEUTRAL, *track_actions(track)]
        for i in np.flatnonzero(of_truth[0]):
            rows += [
                (track, names[i], name, int(drawn[0, i, j]), *interval(share[:, i, j]))
                for j, name in enumerate(names)
            ]
    return rows


def oracle(truth: pd.DataFrame, clusters: pd.DataFrame, region: str) -> pd.DataFrame:
    """The `labels` that truth gives: each cluster by the class of most of its frames.

    Frames whose eye is closed in truth do not count for the eye.
    """
    track = SERIES_TRACK[region]
    both = clusters.merge(truth, on=["clip_id", "frame"])
    names = np.array([NEUTRAL, *track_actions(track)], dtype=object)
    ids = both["cluster"].to_numpy("int64")
    codes = true_codes(both, track, unmeasured_actions(truth, track))
    votes = cluster_votes(ids, codes, clusters["cluster"].max() + 1, track)
    return pd.DataFrame(
        {
            "region": region,
            "cluster": np.arange(len(votes)),
            "action": names[votes.argmax(axis=1)],
        }
    )


def by_thresholds(
    frames: pd.DataFrame, rules: Rules, region: str, side: str
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Single frames named by the rules, as a `clusters` table of classes and the `labels` of these.

    frames: clip_id, frame and the region's channels. What the rules call nothing is Neutral.
    """
    measured = list(series_channels(region, side))
    dead = dead_channels(frames[measured])
    channels = [name for name in measured if name not in dead]
    X = frames[channels].to_numpy("float64")
    found = rules.classify(region, channels, X, rules.rest(X))  # (n_frames,)
    names = classes(region)
    code = np.maximum(pd.Categorical(found, names).codes, 0).astype("int64")
    labels = pd.DataFrame({"region": region, "cluster": range(len(names)), "action": names})
    labels["unmeasured"] = [rules.unmeasured(region, channels)] * len(names)
    return frames[["clip_id", "frame"]].assign(cluster=code, margin=0.0), labels
