"""Rows of a CSV that end before the others do, as the last one of a file that was cut off."""

import csv
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline.errors import BadFile

CUT_OFF = "cut off: "  # begins what stands in the cells that a row lacks


def mark(table: pd.DataFrame, path: Path) -> None:
    """Say so in the cells that a row lacks, and in its last one, which may be cut as well.

    A row is as wide as the last column that is not blank throughout. Only where that one has blank
    cells is the file looked at again.
    """
    blank, width = np.zeros(len(table), bool), table.shape[1]
    for at in range(width - 1, -1, -1):
        kept = table[at].dtype.kind in "iufb"
        blank = np.zeros(len(table), bool) if kept else (table[at] == "").to_numpy(bool)
        if not blank.all():
            width = at + 1
            break
    if not blank.any() or blank.all():
        return
    with open(path, encoding="utf-8-sig", newline="") as file:
        rows = (cells for cells in csv.reader(file) if len(cells) > 1 or "".join(cells).strip())
        lengths = np.array([len(cells) for cells in rows][1:])
    if len(lengths) != len(table):
        return
    for length in np.unique(lengths[lengths < width]):
        cut = list(range(max(length - 1, 1), width))  # the first tells which frame it is
        whole = [at for at in cut if table[at].dtype.kind in "iufb"]
        table[whole] = table[whole].astype(str)
        table.iloc[np.flatnonzero(lengths == length), cut] = f"{CUT_OFF}{length} of {width}"


def refuse_cut_off(cell: object, path: Path, line: int) -> None:
    """Raises BadFile where the cell is one that `mark` has marked."""
    if isinstance(cell, str) and cell.startswith(CUT_OFF):
        found, expected = cell.removeprefix(CUT_OFF).split(" of ")
        raise BadFile(
            path,
            place=f"line {line}",
            found=f"{found} cells",
            expected=expected,
            remedy="The row is cut off: delete the line, or set ingest.bad_values: mask to treat "
            "the frame as a gap.",
        )
