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
    split: Path,
    statistics_table: Path,
    ledger: Path,
    val: float,
    test: float,
    gap_s: float,
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
    decisions.close(ledger, rows["clip_id"])

    trained = rows.loc[rows["part"] == "train", "clip_id"]
    motion = tables.read_all(tables.MOTION, motions)
    measured = statistics(motion[motion["clip_id"].isin(trained)])
    tables.write(tables.STATISTICS, measured, statistics_table)
    sizes = rows["part"].value_counts()
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

    Groups come in random order; each goes to validation or testing while that part wants at least
    half of the group's clips, else to training. Each part with a share gets at least one group.
    """
    sizes = clips["group"].value_counts().sort_index()
    order = rng.permutation(sizes.index.to_numpy(str))
    wanted = {part: share * len(clips) for part, share in shares.items()}
    part_of: dict[str, str] = {}
    for part, want in wanted.items():
        for group in order:
            empty = part not in part_of.values()
            if group not in part_of and want > 0 and (empty or want >= sizes[group] / 2):
                if empty and sizes[group] > max(want, sizes.min()):
                    continue  # a smaller group comes later
                part_of[group] = part
                want -= sizes[group]
    return clips["group"].map(lambda group: part_of.get(group, "train")).to_numpy(str)


def by_time(clips: pd.DataFrame, shares: dict[str, float], gap_s: float) -> np.ndarray:
    """A part per clip in order of time: training first, then validation, then testing.

    Clips of a source that end less than gap_s before a later part begins belong to none (""). A
    part with a share gets at least one clip where there are clips enough.
    """
    order = list(clips.sort_values(["source_id", "start_s"]).index)
    part = pd.Series("train", index=clips.index)
    for name in ("test", "val"):
        size = max(1, round(shares[name] * len(clips))) if shares[name] > 0 else 0
        if size == 0 or len(order) <= size + 1:
            continue
        first = clips.loc[order[-size]]
        part[order[-size:]] = name
        del order[-size:]
        while len(order) > 1 and _too_near(clips.loc[order[-1]], first, gap_s):
            part[order.pop()] = ""
    return part.to_numpy(str)


def _too_near(before: pd.Series, after: pd.Series, gap_s: float) -> bool:
    same = before["source_id"] == after["source_id"]
    return same and after["start_s"] - before["end_s"] < gap_s
