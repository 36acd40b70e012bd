"""Parts for training, validation and testing that share neither source video nor person."""

import logging
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.dataset.statistics import statistics
from mimeline.ledger import Ledger

log = logging.getLogger(__name__)

PARTS = ("train", "val", "test")


def split(
    clips: Sequence[Path],
    motions: Sequence[Path],
    fingerprints: Sequence[Path],
    split: Path,
    duplicates: Path,
    statistics_table: Path,
    ledger: Path,
    val: float,
    test: float,
    gap_s: float,
    near_duplicates: float | None,
    seed: int,
) -> None:
    """Divide the clips (Höll 2024, 5.2.4) and measure the training part.

    clips, motions: one path per shard. val, test: shares of the clips. With fewer than three groups
    of source video and person, contiguous blocks of time take their place, gap_s seconds apart:
    the ledger says so for every clip.
    """
    table = tables.read_all(tables.CLIPS, clips)
    table = table.assign(group=groups(table))
    decisions = Ledger("split", table["clip_id"])
    shares = {"val": val, "test": test}
    if table["group"].nunique() >= len(PARTS):
        part = by_group(table, shares, np.random.default_rng(seed))
    else:
        part = by_time(table, shares, gap_s)
        for clip_id, chosen in zip(table["clip_id"], part, strict=True):
            if chosen == "":
                detail = "between two parts of one recording"
                decisions.drop(clip_id, "split_gap", limit=gap_s, unit="s", detail=detail)
            else:
                decisions.note(clip_id, "split_by_time", detail="fewer than three groups")
    rows = table.assign(part=part)[table["clip_id"].isin(decisions.kept)]
    tables.write(tables.SPLIT, rows, split, reason="" if len(rows) else "no clip came through")
    tables.write(tables.DUPLICATES, tables.empty(tables.DUPLICATES), duplicates)
    decisions.close(ledger, rows["clip_id"])

    trained = rows.loc[rows["part"] == "train", "clip_id"]
    motion = tables.read_all(tables.MOTION, motions)
    measured = statistics(motion[motion["clip_id"].isin(trained)])
    tables.write(tables.STATISTICS, measured, statistics_table)
    sizes = rows["part"].value_counts()
    decisions.tell(log)
    log.info("%s", ", ".join(f"{part} {sizes.get(part, 0)}" for part in PARTS))


def groups(clips: pd.DataFrame) -> list[str]:
    """A name per clip, the same for clips tied by source video or person, also by way of others.

    clips: source_id, subject_id (null where unknown).
    """
    parent: dict[tuple, tuple] = {}

    def root(node):
        while parent.setdefault(node, node) != node:
            node = parent[node]
        return node

    for clip in clips.itertuples():
        if pd.notna(clip.subject_id):
            ends = root(("source", clip.source_id)), root(("person", clip.subject_id))
            parent[max(ends)] = min(ends)
    return ["{}:{}".format(*root(("source", source))) for source in clips["source_id"]]


def by_group(clips: pd.DataFrame, shares: dict[str, float], rng: np.random.Generator) -> np.ndarray:
    """A part per clip, whole groups together.

    Groups come in random order. Each part with a share first gets one, the first that is no larger
    than what it wants, else the smallest; then each group goes to validation or testing while that
    part wants at least half of the group's clips, else to training, which keeps one at least.
    """
    sizes = clips["group"].value_counts().sort_index().to_dict()
    free = dict.fromkeys(rng.permutation(sorted(sizes)).tolist())  # in random order
    wanted = {part: share * len(clips) for part, share in shares.items() if share > 0}
    part_of: dict[str, str] = {}

    def give(group, part):
        part_of[group] = part
        wanted[part] -= sizes[group]
        del free[group]

    for part in list(wanted)[: len(sizes) - 1]:
        least = min(sizes[group] for group in free)
        give(next(group for group in free if sizes[group] <= max(wanted[part], least)), part)
    for part in wanted:
        for group in list(free):
            if len(free) > 1 and wanted[part] >= sizes[group] / 2:
                give(group, part)
    return clips["group"].map(lambda group: part_of.get(group, "train")).to_numpy(str)


def by_time(clips: pd.DataFrame, shares: dict[str, float], gap_s: float) -> np.ndarray:
    """A part per clip in order of time: training first, then validation, then testing.

    Clips of a source that end less than gap_s before a later part begins belong to none (""). A
    part with a share gets at least one clip, but none where that leaves nothing for training.
    """
    order = list(clips.sort_values(["source_id", "start_s"]).index)
    part = pd.Series("train", index=clips.index)
    for name in ("test", "val"):
        size = max(1, round(shares[name] * len(clips))) if shares[name] > 0 else 0
        if size == 0 or len(order) <= size + 1:
            continue
        first = clips.loc[order[-size]]
        before = clips.loc[order[:-size]]
        away = first["start_s"] - before["end_s"] >= gap_s
        far = away | (before["source_id"] != first["source_id"])
        if not far.any():
            continue
        part[order[-size:]] = name
        part[before.index[~far]] = ""
        order = list(before.index[far])
    return part.to_numpy(str)
