"""Parts for training, validation and testing that share no source video, person or content."""

import logging
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.dataset.near_duplicates import near_duplicates as find_near_duplicates
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

    clips, motions, fingerprints: one path per shard. val, test: shares of the clips.
    near_duplicates: clips of which more than that share is alike are in one part, and stand in the
    table duplicates; None: nobody looks. With fewer than three groups of source video, person and
    near-duplicates, contiguous blocks of time take their place, gap_s seconds apart: the ledger
    says so for every clip.
    """
    table = tables.read_all(tables.CLIPS, clips)
    motion = tables.read_all(tables.MOTION, motions)
    decisions = Ledger("split", table["clip_id"])
    pairs = pd.DataFrame(columns=["clip_id", "other_id", "kind", "share", "mirrored"])
    if near_duplicates is not None:
        pictures = tables.read_all(tables.FINGERPRINTS, fingerprints)
        for ties in (groups(table), table["source_id"]):
            known = table.assign(group=ties)
            pairs = find_near_duplicates(known, pictures, motion, near_duplicates)
            if len(set(groups(table, pairs))) >= len(PARTS):
                break  # else time parts what belongs to one group, and the sources of one person
    for pair in pairs.sort_values("share", kind="stable").itertuples():  # the last note counts
        for clip_id, other in ((pair.clip_id, pair.other_id), (pair.other_id, pair.clip_id)):
            decisions.note(
                clip_id,
                "near_duplicate",
                value=pair.share,
                limit=near_duplicates,
                unit="share",
                detail=likeness(other, pair),
            )
    table = table.assign(group=groups(table, pairs))
    shares = {"val": val, "test": test}
    if table["group"].nunique() >= len(PARTS):
        part = by_group(table, shares, np.random.default_rng(seed))
    else:
        part = by_time(table, shares, gap_s)
        leaking = leaks(table["clip_id"], part, pairs)
        for clip_id, chosen in zip(table["clip_id"], part, strict=True):
            if chosen == "":
                detail = "between two parts of one recording"
                decisions.drop(clip_id, "split_gap", limit=gap_s, unit="s", detail=detail)
            elif clip_id in leaking:
                detail = f"{leaking[clip_id]} is in another part"
                decisions.drop(clip_id, "near_duplicate", limit=near_duplicates, detail=detail)
            else:
                decisions.note(clip_id, "split_by_time", detail="fewer than three groups")
    rows = table.assign(part=part)[table["clip_id"].isin(decisions.kept)]
    tables.write(tables.SPLIT, rows, split, reason="" if len(rows) else "no clip came through")
    unsought = "split.near_duplicates is null" if near_duplicates is None else "no two are alike"
    tables.write(tables.DUPLICATES, pairs, duplicates, reason="" if len(pairs) else unsought)
    decisions.close(ledger, rows["clip_id"])

    trained = rows.loc[rows["part"] == "train", "clip_id"]
    motion["valid"] &= motion["clip_id"].isin(trained)
    measured = statistics(motion)
    tables.write(tables.STATISTICS, measured, statistics_table)
    sizes = rows["part"].value_counts()
    decisions.tell(log)
    log.info("%s", ", ".join(f"{part} {sizes.get(part, 0)}" for part in PARTS))


def likeness(other: str, pair) -> str:
    """What the ledger says of a near-duplicate. pair: a row of them."""
    what = "pictures" if pair.kind == "film" else "frames of motion"
    turned = ", mirrored" if pair.mirrored else ""
    return f"{pair.share:.0%} of the {what} of the shorter are those of {other}{turned}"


def groups(clips: pd.DataFrame, pairs: pd.DataFrame | None = None) -> list[str]:
    """A name per clip, the same for clips tied by source video, person or likeness, also by way of
    others; it does not depend on the order of clips or pairs.

    clips: clip_id, source_id, subject_id (null where unknown). pairs: clip_id, other_id of clips
    that show the same.
    """
    parent: dict[tuple, tuple] = {}

    def root(node):
        while parent.setdefault(node, node) != node:
            node = parent[node]
        return node

    def tie(one, other):
        ends = root(one), root(other)
        parent[max(ends)] = min(ends)

    known = clips[clips["subject_id"].notna()]
    for source, person in zip(known["source_id"], known["subject_id"], strict=True):
        tie(("source", source), ("person", person))
    if pairs is not None:
        source_of = dict(zip(clips["clip_id"], clips["source_id"], strict=True))
        for one, other in zip(pairs["clip_id"], pairs["other_id"], strict=True):
            tie(("source", source_of[one]), ("source", source_of[other]))
    return ["{}:{}".format(*root(("source", source))) for source in clips["source_id"]]


def leaks(clip_ids: pd.Series, part: np.ndarray, pairs: pd.DataFrame) -> dict[str, str]:
    """Clips to leave out so that no pair is on two sides, each with the other of its pair.

    part: as by_time gives it. A later part keeps its clips, unless training would lose all of its
    own: then the later part loses those that are alike.
    """
    sides = dict(zip(clip_ids, part, strict=True))
    one_way = list(zip(pairs["clip_id"], pairs["other_id"], strict=True))
    left_out: dict[str, str] = {}
    for later in ("test", "val"):
        earlier = PARTS[: PARTS.index(later)]
        crossing = [
            (one, other)
            for one, other in one_way + [(other, one) for one, other in one_way]
            if sides[one] in earlier and sides[other] == later
        ]
        losing = dict(crossing)
        if {clip for clip, side in sides.items() if side == "train"} <= losing.keys():
            losing = {other: one for one, other in crossing}
        left_out |= losing
        sides |= dict.fromkeys(losing, "")
    return left_out


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
