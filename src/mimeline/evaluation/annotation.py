"""How right the annotation is, against a truth that somebody planted or wrote down."""

import logging
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
from sklearn.mixture import GaussianMixture

from mimeline import tables
from mimeline.annotation.annotate import annotate_frames, unmeasured_actions
from mimeline.annotation.proposals import Rules, read_rules
from mimeline.annotation.queries import classes
from mimeline.annotation.scores import (
    REGION_TRACKS,
    bootstrap,
    cluster_votes,
    confusions,
    true_codes,
)
from mimeline.annotation.series import dead_channels, sequences
from mimeline.annotation.thresholds import Limits
from mimeline.vocabulary import NEUTRAL, SERIES_TRACK, series_channels, track_actions

log = logging.getLogger(__name__)


def evaluate_annotation(
    clips: Sequence[Path],
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
    """Score the annotation per region as macro-F1 (Ma et al. 2025, 4.1), with intervals over clips.

    Variants: "named" is what annotate wrote; "oracle" gives each cluster the name that most of its
    frames have in truth, the best that these clusters allow; "gmm" does so for a Gaussian mixture
    on single frames, whose intervals may be as short as they come; "thresholds" names each frame
    alone by the rules that clusters are proposed names by (the paper's other way, section 2).
    rules: resources/proposals.csv. truth: folder with frames.parquet, or None: then the table is
    empty.
    """
    if truth is None:
        reason = "no truth is known for these recordings"
        tables.write(tables.METRICS, tables.empty(tables.METRICS), metrics, reason)
        tables.write(tables.CONFUSION, tables.empty(tables.CONFUSION), confusion, reason)
        return
    true = tables.read(tables.FRAMES, Path(truth) / "frames.parquet")
    kept = tables.read_all(tables.CLIPS, clips, ["clip_id"])["clip_id"]
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
        gmm = GaussianMixture(gmm_components, n_init=3, random_state=seed).fit(X)
        mixture[region] = points[["clip_id", "frame"]].assign(cluster=gmm.predict(X), margin=0.0)
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

    rng = np.random.default_rng(seed)
    rows = []
    for variant, predicted in variants.items():
        counts = confusions(true, predicted)
        scored = bootstrap(counts, resamples, rng)
        scored.pop("mean", None)  # the paper scores regions apart
        for region, (value, low, high) in scored.items():
            n = max(int(c.sum()) for t, c in counts.items() if t in REGION_TRACKS[region])
            rows.append(("annotation", variant, "all", f"f1_{region}", value, low, high, n, seed))
        log.info("%s: %s", variant, ", ".join(f"{r} {v:.3f}" for r, (v, _, _) in scored.items()))
    table = pd.DataFrame(rows, columns=tables.METRICS.schema.names)
    reason = "" if rows else "truth and annotation measure no frame in common"
    tables.write(tables.METRICS, table, metrics, reason)
    tables.write(tables.CONFUSION, tables.empty(tables.CONFUSION), confusion, "nothing counts yet")


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
