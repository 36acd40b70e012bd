"""Near-duplicates: clips of different groups that show the same, side by side."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from mimeline import tables
from mimeline.reporting.album import Album, Shot

MOST, SIZE = 12, 144  # pairs shown; pixels of a picture
PARTS = {"train": "training", "val": "validation", "test": "testing"}
KINDS = {"film": "the film", "motion": "the motion"}


@dataclass(frozen=True)
class Pair:
    """Two clips, what they share and how much of the shorter one, and where the split put them."""

    clips: tuple[str, str]
    what: str
    share: float
    place: str
    shots: tuple[Shot, Shot]


@dataclass(frozen=True)
class Pairs:
    """total: of all pairs; the most alike are shown. reason: why there is none."""

    shown: list[Pair]
    total: int
    reason: str


def pairs(
    duplicates: str | Path, clips: pd.DataFrame, parts: Mapping[str, str], album: Album
) -> Pairs:
    """clips: `clips` kept. duplicates: the table. parts: clip → train, val or test.

    album: is asked for the middle of each clip.
    """
    table = tables.read(tables.DUPLICATES, duplicates)
    alike = table.groupby(["clip_id", "other_id"], sort=False).agg(
        what=("kind", list), share=("share", "max")
    )
    alike = alike.sort_values("share", ascending=False, kind="stable").head(MOST)
    middle = dict(zip(clips["clip_id"], clips["n_frames"].astype(int) // 2, strict=True))
    shown = [
        Pair(
            both,
            " and ".join(KINDS[kind] for kind in row.what),
            float(row.share),
            _place([parts.get(clip) for clip in both]),
            tuple(album.ask(clip, middle.get(clip, 0), SIZE) for clip in both),
        )
        for both, row in zip(alike.index, alike.itertuples(), strict=True)
    ]
    total = len(table.drop_duplicates(["clip_id", "other_id"]))
    return Pairs(shown, total, "" if total else tables.reason(duplicates))


def _place(parts: Sequence[str | None]) -> str:
    if None in parts:
        return "one is left out"
    return f"both for {PARTS[parts[0]]}" if len(set(parts)) == 1 else "on two sides"
