"""Motion of clips between its table and the arrays that are scored and made."""

import logging
from collections.abc import Sequence

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.annotation.runs import run_starts
from mimeline.vocabulary import CHANNELS

log = logging.getLogger(__name__)


def clip_values(
    motion: pd.DataFrame, ids: Sequence[str], channels: Sequence[str]
) -> list[list[np.ndarray]]:
    """Of each of these clips its stretches of valid frames, (L, D) each, in the order of ids.

    A frame counts where every channel was measured. A clip that lacks a channel altogether counts
    nothing, since a Fréchet distance needs them all: the log says how many. What counts nothing is
    one empty stretch.
    """
    motion = motion[motion["clip_id"].isin(ids) & motion["valid"].astype(bool)]
    measured = motion[list(channels)].notna()
    whole = measured.groupby(motion["clip_id"]).any().all(axis=1)  # by clip
    if not whole.all():
        log.warning(
            "%d of %d real clips lack a channel of the model: nothing is compared with them",
            (~whole).sum(),
            len(whole),
        )
    frames = motion[measured.all(axis=1)]
    values = frames[list(channels)].to_numpy(np.float64)
    starts = run_starts(frames)
    stretches = np.split(values, starts[1:]) if len(starts) else []
    found: dict[str, list[np.ndarray]] = {}
    for clip, stretch in zip(frames["clip_id"].to_numpy()[starts], stretches, strict=True):
        found.setdefault(clip, []).append(stretch)
    nothing = np.zeros((0, len(channels)))
    return [found.get(clip, [nothing]) for clip in ids]


def moving(clips: Sequence[Sequence[np.ndarray]]) -> int:
    """How many of the clips of `clip_values` count."""
    return sum(any(len(stretch) for stretch in clip) for clip in clips)


def motion_table(
    frames: pd.DataFrame, made: Sequence[np.ndarray], channels: Sequence[str]
) -> pd.DataFrame:
    """Generated motion, (L, D) per clip in the order of frames, as a `motion` table."""
    absent = dict.fromkeys([c for c in CHANNELS if c not in channels], np.nan)
    facts = {"valid": True, "confidence": np.nan, "tracker_loss": np.nan}
    values = pd.DataFrame(np.concatenate(made), columns=list(channels))
    table = pd.concat([frames[["clip_id", "frame"]], values], axis=1).assign(**facts, **absent)
    return table[tables.MOTION.schema.names]
