"""FACS action units as ARKit channels, where the two describe the same movement.

Units after Ekman and Friesen (2002), Facial Action Coding System; shapes after Apple's pages on
ARFaceAnchor.BlendShapeLocation. The correspondence is `resources/action_units.csv`. A unit tells
no side: both sides get the same number.
"""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline.errors import BadFile
from mimeline.tracking.formats.columns import line_of
from mimeline.tracking.take import Origin
from mimeline.vocabulary import EXPRESSIONS, resource

STRONGEST = 5.0  # FACS intensity E
INTENSITY_RANGE = (-1.0, 6.0)  # estimates of 0-5 overshoot a little


@dataclass(frozen=True)
class ActionUnit:
    """unit: "AU12". channels: the ARKit channels that move alike, none where there are none.

    scale: a channel at the strongest unit. note: what is lost, or why there is no channel.
    """

    unit: str
    name: str
    channels: tuple[str, ...]
    scale: float
    note: str


def _rows() -> list[dict[str, str]]:
    with open(resource("action_units.csv"), encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


ACTION_UNITS: tuple[ActionUnit, ...] = tuple(
    ActionUnit(
        row["unit"],
        row["name"],
        tuple(row["channels"].split()),
        float(row["scale"] or 0),
        row["note"],
    )
    for row in _rows()
)


def clipped(intensities: pd.DataFrame, path: Path) -> tuple[pd.DataFrame, int]:
    """The intensities within 0-5, and how many were not. Raises BadFile far outside of it.

    A post-processing that was interrupted leaves some below 0. The index counts the file's rows.
    """
    low, high = INTENSITY_RANGE
    beyond = ((intensities < low) | (intensities > high)).to_numpy()
    if beyond.any():
        row, column = np.argwhere(beyond)[0]
        raise BadFile(
            path,
            place=f"line {line_of(path, intensities.index[row])}, "
            f"column {intensities.columns[column]}",
            found=f"{intensities.iat[row, column]:g}",
            expected=f"an intensity from 0 to {STRONGEST:g}",
            remedy="Bring the intensities back to their scale; else run the tracker again.",
        )
    outside = (intensities < 0) | (intensities > STRONGEST)
    return intensities.clip(0, STRONGEST), int(outside.to_numpy().sum())


def channels(rows: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, Origin]]:
    """The ARKit channels in [0, 1] that the units of a table tell, and how each was had.

    rows: columns AU01_r, AU02_r ... of 0-5, as many as there are; NaN stays NaN.
    Every expression channel has an origin: where no unit tells it, why not.
    """
    columns: dict[str, pd.Series] = {}
    origins = dict.fromkeys(EXPRESSIONS, Origin("no action unit tells it", measured=False))
    for unit in ACTION_UNITS:
        column = f"{unit.unit}_r"
        for channel in unit.channels:
            if column not in rows:
                origins[channel] = Origin(f"{unit.unit} is not in the table", measured=False)
                continue
            columns[channel] = unit.scale / STRONGEST * rows[column]
            sides = ", both sides alike" if len(unit.channels) > 1 else ""
            origins[channel] = Origin(f"{unit.unit} ({unit.name}) / {STRONGEST:g}{sides}")
    return pd.DataFrame(columns, index=rows.index), origins
