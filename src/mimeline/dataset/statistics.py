"""Mean and spread of each channel over the training part."""

import pandas as pd

from mimeline import tables
from mimeline.vocabulary import CHANNELS


def statistics(motion: pd.DataFrame) -> pd.DataFrame:
    """The `statistics` table of motion's valid frames.

    measured: share of valid frames that have the channel; the other columns are NaN where it is 0.
    """
    seen = motion["valid"].to_numpy(bool)
    rows = []
    for name in CHANNELS:  # one by one: all of them in double precision would be large
        values = motion[name][seen].astype("float64")
        share = values.notna().mean() if len(values) else 0.0
        spread = values.mean(), values.std(ddof=0), values.min(), values.max()
        rows.append((name, share, *spread))
    return pd.DataFrame(rows, columns=tables.STATISTICS.schema.names)
