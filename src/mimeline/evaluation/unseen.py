"""Clips that training has not seen, whose timelines a model is asked for."""

import numpy as np
import pandas as pd

LEAST_UNSEEN = 4  # fewer clips kept out of training say little: then training clips are added


def choose(
    split: pd.DataFrame, frames: pd.DataFrame, wanted: int, rng: np.random.Generator
) -> tuple[str, list[str], list[str]]:
    """The clips whose timelines are asked for: of the test part, then val.

    Training clips are added only where the others are fewer than LEAST_UNSEEN. Returns the parts
    used ("test+val"), at most `wanted` clip ids, and as many other ids to compare with.
    """
    annotated = frames["clip_id"].unique()
    split = split[split["clip_id"].isin(annotated)]
    found: list[str] = []
    used: list[str] = []
    rest: list[str] = []
    for part in ("test", "val", "train"):
        own = rng.permutation(sorted(split.loc[split["part"] == part, "clip_id"])).tolist()
        enough = LEAST_UNSEEN if part == "train" else wanted
        taken = own[: wanted - len(found)] if len(found) < min(enough, wanted) else []
        if taken:
            used.append(part)
        found += taken
        rest = [*own[len(taken) :], *rest]  # training clips first: there are most of them
    return "+".join(used) or "none", sorted(found), sorted(rest[: len(found)])
