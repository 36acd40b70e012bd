"""Timelines that models are compared on: those of unseen clips, and two kinds made to probe."""

from collections.abc import Callable, Collection, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.evaluation.timeline import choose
from mimeline.evaluation.variants import CONFLICT, GLANCES, SETS, UNSEEN
from mimeline.vocabulary import ACTIONS, track_actions

SMILES = ("SoftSmile", "Smile")
GAZES = (*track_actions("gaze_h"), *track_actions("gaze_v"))
SMILE, GLANCE = (30, 80), (30, 60)  # frames that an action is held, least and most
PAUSE = (20, 48)  # frames between two
SHIFT = 8  # most frames by which a raised brow starts, or ends, before or after its smile


def requests(
    frames: Sequence[str | Path],
    split: str | Path,
    asked: Sequence[str | Path],
    unseen: int,
    choice_seed: int,
    timelines: int,
    length: int,
    seed: int,
) -> None:
    """Write a `frames` table of each of SETS: the timelines that every variant is asked for.

    unseen: of at most that many clips that training has not seen, as evaluate chooses them with
    choice_seed. conflict, glances: so many timelines of so many frames, drawn with the seed; empty
    where the clips' own timelines do not tell of the actions, and then they say so.
    """
    marked = tables.read_all(tables.FRAMES, frames)
    rng = np.random.default_rng(choice_seed)
    _, ids, _ = choose(tables.read(tables.SPLIT, split), marked, unseen, rng)
    real = marked[marked["clip_id"].isin(ids)]
    measured = [action for action in ACTIONS if marked[action].notna().any()]
    kinds = {
        CONFLICT: (conflict, (*SMILES, "BrowUp")),
        GLANCES: (glances, GAZES),
    }
    reason = "" if ids else "no clip is annotated"
    tables.write(tables.FRAMES, real, asked[SETS.index(UNSEEN)], reason)
    for name, (draw, needed) in kinds.items():
        lacking = [action for action in needed if action not in measured]
        reason = f"not measured: {', '.join(lacking)}" if lacking else ""
        rng = np.random.default_rng([seed, SETS.index(name)])
        drawn = [] if lacking else [draw(length, rng) for _ in range(timelines)]
        table = as_frames(name, drawn, measured)
        tables.write(tables.FRAMES, table, asked[SETS.index(name)], reason)


def conflict(length: int, rng: np.random.Generator) -> np.ndarray:
    """(length, 16) bool: smiles of either size, each with raised brows, and nothing else."""

    def act(timeline: np.ndarray, first: int, last: int) -> None:
        timeline[first:last, _column(SMILES[rng.integers(len(SMILES))])] = True
        early, late = rng.integers(-SHIFT, SHIFT, 2, endpoint=True)
        timeline[first + early : last + late, _column("BrowUp")] = True

    return _filled(length, SMILE, act, rng)


def glances(length: int, rng: np.random.Generator) -> np.ndarray:
    """(length, 16) bool: gazes in one of four directions, one after another, the head at rest."""

    def act(timeline: np.ndarray, first: int, last: int) -> None:
        timeline[first:last, _column(GAZES[rng.integers(len(GAZES))])] = True

    return _filled(length, GLANCE, act, rng)


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


def _filled(
    length: int,
    hold: tuple[int, int],
    act: Callable[[np.ndarray, int, int], None],
    rng: np.random.Generator,
) -> np.ndarray:
    """A timeline with an act every now and then: act(timeline, first frame, behind the last)."""
    timeline = np.zeros((length, len(ACTIONS)), dtype=bool)
    first = int(rng.integers(*PAUSE, endpoint=True))
    while (last := first + int(rng.integers(*hold, endpoint=True))) + SHIFT <= length:
        act(timeline, first, last)
        first = last + int(rng.integers(*PAUSE, endpoint=True))
    return timeline


def _column(action: str) -> int:
    return list(ACTIONS).index(action)
