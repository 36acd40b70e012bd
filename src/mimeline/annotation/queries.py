"""Where a look at an exemplar helps most."""

import numpy as np
import pandas as pd


def worth(labels: pd.DataFrame) -> np.ndarray:
    """(n_clusters,) the share of a region's frames whose name an answer is expected to put right.

    labels: the `labels` table, proposed names in it or a person's.
    """
    unsure = 1 - labels["confidence"].fillna(0.0).to_numpy("float64")
    return labels["share"].to_numpy("float64") * unsure * (labels["source"] != "human").to_numpy()
