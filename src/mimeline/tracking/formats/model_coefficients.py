"""What the coefficients of FLAME and of the Basel Face Model have in common."""

from pathlib import Path

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from mimeline.errors import BadFile

LARGEST = 100.0  # coefficients count standard deviations: what is beyond is no coefficient


def refuse_beyond(rows: pd.DataFrame, place: str, remedy: str, path: Path) -> None:
    """Raises BadFile where a number can be no coefficient. place: what comes before its column."""
    largest = rows.abs().max()
    if (largest > LARGEST).any():
        raise BadFile(
            path,
            place=f"{place}{largest.idxmax()}",
            found=f"{largest.max():.3g}",
            expected=f"coefficients within {LARGEST:g}",
            remedy=remedy,
        )


def rotations_of(vectors: pd.DataFrame) -> np.ndarray:
    """Matrices (n, 3, 3) of rotations (n, 3) by axis times angle; NaN where a row is."""
    return Rotation.from_rotvec(np.array(vectors, np.float64)).as_matrix()
