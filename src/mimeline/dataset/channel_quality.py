"""What each channel is worth to a training: whether it is learnt, moves, and stays in its range."""

import math

import numpy as np
import pandas as pd

from mimeline.dataset.windows import Normaliser
from mimeline.tracking.detectors import OVERSHOOT, REACH
from mimeline.vocabulary import CHANNELS, DEAD_RANGE

# What a face can do, by kind of channel: coefficients, and radians to either side.
PHYSICAL: dict[str, tuple[float, float]] = {
    "expression": (-OVERSHOOT, 1 + OVERSHOOT),
    "head": (-REACH, REACH),
    "gaze": (-math.radians(60), math.radians(60)),
}
QUANTILES = 0.01, 0.99  # of training; an outlier is farther from them than they are from each other
LEAST_SPREAD = 0.1  # between them, of a coefficient or in radians: who seldom moves may move


def channel_quality(
    motion: pd.DataFrame, statistics: pd.DataFrame, train: set[str]
) -> pd.DataFrame:
    """A row per channel, indexed by its name.

    motion: the table's rows of the clips to look at. statistics: of the training part. train: its
    clips. What is said of values is of valid frames of all clips.

    Returns learnt (whether training takes the channel) and why_not ("not measured", "measured in
    too few frames" or empty); measured (share of valid training frames); constant (it moves by less
    than DEAD_RANGE in training); without (training clips that lack it, though others have it);
    outside (number of values out of PHYSICAL); outliers (number of values, see `outlying`); and
    clip_id, frame and value of the worst of them, null without any.
    """
    learnt = set(Normaliser.from_statistics(statistics).channels)
    told = statistics.set_index("channel")
    seen = motion[motion["valid"].to_numpy(bool)].reset_index(drop=True)
    in_training = seen["clip_id"].isin(train).to_numpy(bool)
    known = seen.loc[in_training, list(CHANNELS)].notna()
    lacking = ~known.groupby(seen["clip_id"][in_training]).any()  # (n_clips, n_channels)
    rows = {}
    for name, channel in CHANNELS.items():
        values = seen[name].to_numpy("float64")  # (n_frames,)
        share = told["measured"].get(name, 0.0)
        low, high = PHYSICAL[channel.kind]
        outside = (values < low) | (values > high)
        past = outlying(values, values[in_training])
        worst = int(np.argmax(past)) if (past > 0).any() else None
        few = "not measured" if share == 0 else "measured in too few frames"
        rows[name] = {
            "learnt": name in learnt,
            "why_not": "" if name in learnt else few,
            "measured": share,
            "constant": share > 0 and told["high"][name] - told["low"][name] < DEAD_RANGE,
            "without": int(lacking[name].sum()) if share > 0 else 0,
            "outside": int(outside.sum()),
            "outliers": int((past > 0).sum()),
            "clip_id": None if worst is None else seen["clip_id"].iat[worst],
            "frame": None if worst is None else int(seen["frame"].iat[worst]),
            "value": math.nan if worst is None else values[worst],
        }
    found = pd.DataFrame.from_dict(rows, orient="index")
    return found.astype({"frame": "Int64"})


def outlying(values: np.ndarray, of_training: np.ndarray) -> np.ndarray:
    """How far each value lies past the fences of training, in spreads; 0 within and where NaN.

    values (n,), of_training (m,): of a channel. The spread is the distance of the 1st and the 99th
    percentile of training, at least LEAST_SPREAD; the fences lie a spread below the one and above
    the other. A rule of quantiles, since coefficients rest near 0 and a blink is many s.d. away.
    """
    known = of_training[np.isfinite(of_training)]
    if not len(known):
        return np.zeros(len(values))
    low, high = np.quantile(known, QUANTILES)
    spread = max(high - low, LEAST_SPREAD)
    beyond = np.maximum(values - high, low - values) / spread - 1
    return np.where(beyond > 0, beyond, 0.0)  # NaN is not > 0
