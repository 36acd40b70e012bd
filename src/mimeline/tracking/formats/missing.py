"""What programs write in place of a number that they do not have."""

import numpy as np
import pandas as pd

# as C, NumPy and pandas write it, in small letters
WORDS = ("nan", "-nan", "nan(ind)", "-nan(ind)", "-1.#ind", "1.#qnan")


def blanked(cells: pd.DataFrame) -> tuple[pd.DataFrame, np.ndarray]:
    """Cells with "" where a word says that there is no number, and where that is, (n, m) bool."""
    words = [name for name in cells if cells[name].dtype.kind not in "fiub"]
    if not words:
        return cells, np.zeros(cells.shape, bool)
    stripped = cells[words].apply(lambda column: column.astype(str).str.strip())
    told = stripped.apply(lambda column: column.str.casefold().isin(WORDS))
    missing = told.reindex(columns=cells.columns, fill_value=False).to_numpy(bool)
    return cells.assign(**stripped.where(~told, "")), missing
