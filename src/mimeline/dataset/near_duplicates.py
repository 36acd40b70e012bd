"""Clips of different groups that show the same: the same film, or the same take."""

import logging

import pandas as pd

from mimeline.dataset.alike_films import alike_films
from mimeline.dataset.alike_motion import Motion, alike_motion, moves_alike

log = logging.getLogger(__name__)

COLUMNS = ["clip_id", "other_id", "kind", "share", "mirrored"]
LEEWAY_S = 1.5  # pictures are a second apart, so a film's offset is known that well
LEAST_SECONDS = 1.0  # that two films have in common before their motion tells anything


def near_duplicates(
    clips: pd.DataFrame, fingerprints: pd.DataFrame, motion: pd.DataFrame, least_share: float
) -> pd.DataFrame:
    """Pairs of clips of two groups of which more than least_share is the same.

    clips: clip_id, group, fps_num, fps_den. fingerprints, motion: the tables of these names.
    Pictures that are alike may show two people in one studio: where both clips are tracked they are
    the same only if they move alike, too.
    Returns clip_id, other_id, kind (film or motion), share of the shorter clip, mirrored.
    """
    groups = clips.set_index("clip_id")["group"]
    rates = (clips["fps_num"] / clips["fps_den"]).astype(float).set_axis(clips["clip_id"])
    moving = Motion(motion)
    films = alike_films(fingerprints, rates, groups, least_share)
    told = [_performed_once(pair, moving, rates) for pair in films.itertuples()]
    films = films[told].assign(kind="film")
    if len(told) > len(films):
        log.info("%d pairs of clips look alike but move differently", len(told) - len(films))
    takes = alike_motion(moving, groups, least_share).assign(kind="motion")
    pairs = pd.concat([films, takes], ignore_index=True)[COLUMNS]
    return pairs.sort_values(COLUMNS[:3], ignore_index=True)


def _performed_once(pair, motion: Motion, rates: pd.Series) -> bool:
    """Whether nothing that is tracked speaks against it."""
    rate, other_rate = rates[pair.clip_id], rates[pair.other_id]
    if rate != other_rate:
        return True
    middle, leeway = round(pair.offset_s * rate), round(LEEWAY_S * rate)
    offsets = range(middle - leeway, middle + leeway + 1)
    one, other = motion.values(pair.clip_id), motion.values(pair.other_id, pair.mirrored)
    return moves_alike(one, other, offsets, round(LEAST_SECONDS * rate)) is not False
