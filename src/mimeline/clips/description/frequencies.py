"""How often what is shown is shown, and weights that even it out."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

MOST = 20.0  # times that a clip may count as much as another

MOVING = ("action", "emotion", "timeline")  # what a motion model learns to show


def frequencies(shown: pd.DataFrame, n_clips: int) -> pd.DataFrame:
    """The `attributes` table: each attribute's clips, their share of all, and its seconds.

    shown: a row per clip and attribute with clip_id, kind, attribute, seconds (NaN for what holds
    of the whole clip).
    """
    by_attribute = shown.groupby(["kind", "attribute"], sort=True)
    table = by_attribute.agg(clips=("clip_id", "nunique")).reset_index()
    table["share"] = table["clips"] / max(n_clips, 1)
    table["seconds"] = by_attribute["seconds"].sum(min_count=1).to_numpy()
    return table


def evened(clip_ids: Sequence[str], shown: pd.DataFrame, balance: float) -> pd.DataFrame:
    """The `weights` table: a clip counts by the rarest of the moving things that it shows.

    A clip's weight is the largest (n_commonest / n)^balance of what it shows, n being the clips
    that show it; no clip counts more than MOST times another, and the mean is 1. A clip that shows
    nothing counts as one that shows the commonest. This is the repeat factor of Gupta, Dollár and
    Girshick 2019 (LVIS, section 4.2), whose square root is balance 0.5, with the commonest in the
    place of their threshold.

    shown: as for `frequencies`; only its kinds action, emotion and timeline count.
    balance: 0 leaves all weights at 1, 1 makes attributes count the same where no two are shown by
    one clip.
    """
    moving = shown[shown["kind"].isin(MOVING)]
    n_clips = moving.groupby(["kind", "attribute"])["clip_id"].transform("nunique")
    factors = (n_clips.max() / n_clips) ** balance
    by_clip = factors.groupby(moving["clip_id"]).max()
    factor = np.minimum(by_clip.reindex(clip_ids, fill_value=1.0).to_numpy(float), MOST)
    weight = factor / factor.mean() if len(factor) else factor
    return pd.DataFrame({"clip_id": list(clip_ids), "weight": weight})
