"""What the annotation takes for what: per track, how the frames of each true action were named."""

from dataclasses import dataclass

import pandas as pd

from mimeline.annotation.scores import confusions
from mimeline.reporting import words
from mimeline.vocabulary import NEUTRAL, SERIES_TRACK, track_actions


@dataclass(frozen=True)
class Row:
    """A true action, its frames, and per found action their share: number, text, whether right."""

    action: str
    frames: int
    cells: list[tuple[float, str, bool]]


@dataclass(frozen=True)
class Matrix:
    """names: the found actions, Neutral first, as the rows are."""

    region: str
    names: list[str]
    rows: list[Row]


def matrices(frames: pd.DataFrame, truth: pd.DataFrame | None) -> list[Matrix]:
    """One per series region that both `frames` tables measure; actions without a frame left out."""
    if truth is None or frames.empty or truth.empty:
        return []
    counts = confusions(truth, frames)
    found = []
    for region, track in SERIES_TRACK.items():
        if track not in counts:
            continue
        table = counts[track].sum(axis=0)  # (C, C), truth in rows
        names = [NEUTRAL, *track_actions(track)]
        rows = [
            Row(
                name,
                int(own.sum()),
                [
                    (float(n / own.sum()), words.percent(n / own.sum()) if n else "", i == j)
                    for j, n in enumerate(own)
                ],
            )
            for i, (name, own) in enumerate(zip(names, table, strict=True))
            if own.sum()
        ]
        found.append(Matrix(region, names, rows))
    return found
