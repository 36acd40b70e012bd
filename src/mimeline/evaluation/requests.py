"""Timelines that models are compared on: those of unseen clips, and some whose actions conflict."""

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.evaluation.unseen import choose
from mimeline.evaluation.variants import CONFLICT, UNSEEN
from mimeline.vocabulary import ACTIONS

SMILES = ("SoftSmile", "Smile")
SMILE = (30, 80)  # frames that one is held, least and most
PAUSE = (20, 48)  # frames between two
SHIFT = 8  # most frames by which a raised brow starts, or ends, before or after its smile


def requests(
    frames: Sequence[str | Path],
    split: str | Path,
    asked: Mapping[str, Path],
    unseen: int,
    choice_seed: int,
    timelines: int,
    length: int,
    seed: int,
) -> None:
    """Write the timelines that every variant is asked for: by set of ASKED, a `frames` table.

    unseen: of at most that many clips that training has not seen, as evaluate chooses them with
    choice_seed. conflict: so many timelines of so many frames, drawn with the seed; empty where the
    clips' own timelines do not tell of smiles and raised brows, and then it says so.
    """
    marked = tables.read_all(tables.FRAMES, frames)
    rng = np.random.default_rng(choice_seed)
    _, ids, _ = choose(tables.read(tables.SPLIT, split), marked, unseen, rng)
    real = marked[marked["clip_id"].isin(ids)]
    tables.write(tables.FRAMES, real, asked[UNSEEN], "" if ids else "no clip is annotated")
    measured = [action for action in ACTIONS if marked[action].notna().any()]
    lacking = [action for action in (*SMILES, "BrowUp") if action not in measured]
    rng = np.random.default_rng(seed)
    drawn = [] if lacking else [conflict(length, rng) for _ in range(timelines)]
    reason = f"not measured: {', '.join(lacking)}" if lacking else ""
    tables.write(tables.FRAMES, as_frames(CONFLICT, drawn, measured), asked[CONFLICT], reason)


def conflict(length: int, rng: np.random.Generator) -> np.ndarray:
    """(length, 16) bool: smiles of either size, each with raised brows, and nothing else.

    There is one from 136 frames on, the least that may be configured.
    """
    timeline = np.zeros((length, len(ACTIONS)), dtype=bool)
    first = int(rng.integers(*PAUSE, endpoint=True))
    while (last := first + int(rng.integers(*SMILE, endpoint=True))) + SHIFT <= length:
        timeline[first:last, _column(SMILES[rng.integers(len(SMILES))])] = True
        early, late = rng.integers(-SHIFT, SHIFT, 2, endpoint=True)
        timeline[first + early : last + late, _column("BrowUp")] = True
        first = last + int(rng.integers(*PAUSE, endpoint=True))
    return timeline


def as_frames(
    name: str, timelines: Sequence[np.ndarray], measured: Collection[str]
) -> pd.DataFrame:
    """Timelines (L, 16) as a `frames` table of clips name-000, …; null: what is not measured."""
    if not timelines:
        return tables.empty(tables.FRAMES)
    lengths = [len(timeline) for timeline in timelines]
    names = np.array([f"{name}-{number:03d}" for number in range(len(timelines))], dtype=object)
    told = pd.DataFrame(np.concatenate(timelines), columns=list(ACTIONS), dtype="boolean")
    told.loc[:, [action for action in ACTIONS if action not in measured]] = pd.NA
    told.insert(0, "clip_id", pd.array(np.repeat(names, lengths), dtype="str"))
    told.insert(1, "frame", np.concatenate([np.arange(length) for length in lengths]))
    return told


def _column(action: str) -> int:
    return list(ACTIONS).index(action)
