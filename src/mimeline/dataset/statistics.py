"""Mean and spread of each channel over the training part."""

import pandas as pd

from mimeline import tables
from mimeline.vocabulary import CHANNELS


def statistics(motion: pd.DataFrame) -> pd.DataFrame:
    """The `statistics` table of motion's valid frames.

    measured: share of valid frames that have the channel; the other columns are NaN where it is 0.
    """
    values = motion.loc[motion["valid"].astype(bool), list(CHANNELS)].astype("float64")
    share = values.notna().mean() if len(values) else pd.Series(0.0, index=list(CHANNELS))
    columns = {
        "channel": list(CHANNELS),
        "measured": share.to_numpy(),
        "mean": values.mean().to_numpy(),
        "std": values.std(ddof=0).to_numpy(),
        "low": values.min().to_numpy(),
        "high": values.max().to_numpy(),
    }
    return pd.DataFrame(columns)[tables.STATISTICS.schema.names]
