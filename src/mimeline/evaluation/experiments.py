"""The experiments of Ma et al. 2025, 4.1, on one region."""

import logging
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.annotation.proposals import read_rules
from mimeline.annotation.timelines import read_truth
from mimeline.errors import MimelineError
from mimeline.evaluation.attempts import REFERENCE, LeftOut, Plan, Recordings, attempts
from mimeline.evaluation.sweep import series_truth
from mimeline.progress import told
from mimeline.vocabulary import NEUTRAL, series_actions

log = logging.getLogger(__name__)

NO_TRUTH = "no truth is known for these recordings"
ONE_CLIP = "truth is known of one clip alone, which tells nothing of others"
KEYS = ["region", "experiment", "setting", "seed"]


def experiments(
    clips: Sequence[Path],
    ledgers: Sequence[Path],
    motions: Sequence[Path],
    units: Sequence[Path],
    rules: Path,
    truth: Path | None,
    found: Path,
    left_out: Path,
    region: str,
    side: str,
    n_clusters: Sequence[int],
    betas: Sequence[float],
    null_length: int,
    null_value: float,
    configured: Mapping[str, Any],
    seeds: int,
    unseen: float,
    claspy: str | None,
) -> None:
    """Write the `experiments` table of a region, and `left_out`: settings without a result.

    clips, motions, units: tables `clips`, `motion` and `action_units`. ledgers: of the stages
    before. rules: proposals.csv. truth: of `read_truth`, or None: then nothing is tried.
    configured: TICC's arguments; its n_clusters and beta are the reference, its seed the first of
    the seeds. null_length, null_value: of the separators. unseen: share of the sources. claspy:
    interpreter of an environment that has it.
    """
    if truth is None:
        _write_none(NO_TRUTH, found, left_out)
        return
    kept = tables.read_all(tables.CLIPS, clips)
    plan = Plan(
        region,
        side,
        {**configured, "null_length": null_length, "null_value": null_value},
        n_clusters,
        betas,
        unseen,
        read_rules(rules),
        claspy,
    )
    table = tables.COEFFICIENTS["action_units"]
    motion, measured = tables.read_all(tables.MOTION, motions), tables.read_all(table, units)
    true = read_truth(truth, kept, tables.read_all(tables.LEDGER, ledgers))
    recordings = recorded(kept, motion, measured, true, region)
    if recordings.truth.query("truth >= 0")["clip_id"].nunique() == 1:
        _write_none(ONE_CLIP, found, left_out)
        return
    rows, missing = tried(recordings, plan, seeds)
    reason = "" if len(rows) else "; ".join(missing["reason"].unique()) or "no frame counts"
    tables.write(tables.EXPERIMENTS, rows, found, reason)
    tables.write(tables.LEFT_OUT, missing, left_out)
    log.info("%s: %d settings", region, rows.groupby(["experiment", "setting"]).ngroups)


def _write_none(reason: str, found: Path, left_out: Path) -> None:
    tables.write(tables.EXPERIMENTS, tables.empty(tables.EXPERIMENTS), found, reason)
    tables.write(tables.LEFT_OUT, tables.empty(tables.LEFT_OUT), left_out)


def recorded(
    clips: pd.DataFrame,
    motion: pd.DataFrame,
    units: pd.DataFrame,
    true: pd.DataFrame,
    region: str,
) -> Recordings:
    """What the experiments on a region take. clips, motion, units, true: tables, `frames` last."""
    kept = motion[motion["clip_id"].isin(clips["clip_id"])].reset_index(drop=True)
    truth = kept[["clip_id", "frame"]].assign(truth=series_truth(kept, true, region))
    return Recordings(kept, units, truth, clips.set_index("clip_id")["source_id"].to_dict())


def tried(
    recordings: Recordings, plan: Plan, seeds: int, only: Collection[str] | None = None
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """The tables `experiments` and `left_out` of a plan, a fit of each setting for each seed.

    What no seed changes is found once, under the first. only: these experiments and the reference.
    """
    first = plan.configured["seed"]
    asked = None if only is None else {REFERENCE[0], *only}
    every = [a for a in attempts(recordings, plan) if asked is None or a.experiment in asked]
    runs = [(a, first + n) for n in range(seeds) for a in every if a.seeded or not n]
    counts, reasons = [], {}
    for attempt, seed in told(runs, f"runs of experiments on the {plan.region} series", log):
        names = [(plan.region, attempt.experiment, setting) for setting in attempt.settings]
        try:
            results = attempt.find(seed)
        except (LeftOut, ValueError, MimelineError) as error:
            for name in names:
                if name not in reasons:
                    log.info("%s, %s %s is left out: %s", *name, error)
                reasons.setdefault(name, str(error))
            continue
        counts += [_counts(r, (*name, seed)) for name, r in zip(names, results, strict=True)]
    rows = pd.concat(counts, ignore_index=True) if counts else tables.empty(tables.EXPERIMENTS)
    there = set(zip(*(rows[name] for name in KEYS[:3]), strict=True))
    missing = [(*name, reason) for name, reason in reasons.items() if name not in there]
    return rows, pd.DataFrame(missing, columns=tables.LEFT_OUT.schema.names)


def _counts(judged: pd.DataFrame, key: tuple[str, str, str, int]) -> pd.DataFrame:
    """Frames of each clip by true and found class. judged: clip_id, truth, found."""
    names = np.array([NEUTRAL, *series_actions(key[0])], dtype=object)
    sizes = judged.groupby(["clip_id", "truth", "found"]).size().rename("frames").reset_index()
    for column in ("truth", "found"):
        sizes[column] = names[sizes[column].to_numpy("int64")]
    return sizes.assign(**dict(zip(KEYS, key, strict=True)))
