"""How far the head goes with the eyes, which no timeline tells (Ma et al. 2025, 4.2)."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pandas as pd

from mimeline.annotation.runs import run_starts
from mimeline.vocabulary import ACTIONS, track_actions

# gaze track → its angle, that of the head beside it, and what else moves that: there all is quiet
FOLLOWS = {
    "gaze_h": ("gaze_left", "head_yaw_left", track_actions("head_h")),
    "gaze_v": ("gaze_up", "head_pitch_up", (*track_actions("head_v"), "BrowUp")),
}
LAG = 4  # frames that the head comes after the eyes
ONSET, OFFSET = 8, 2  # frames of a gaze that are left out, at its beginning and its end
LEAST_HELD = 16  # frames of a gaze, below which little of it is left
LEAST_GAZES = 12  # of a track, below which a slope says nothing


def gazes(frames: pd.DataFrame, motion: pd.DataFrame) -> pd.DataFrame:
    """A row for each gaze that is held while the head is told, or found, to be at rest.

    frames, motion: tables with the same frames of the same clips. What is not measured may be
    anything, and is no rest. Returns clip_id, track, action, gaze and head: the mean angles in
    radians over the held part, that of the head LAG frames later.
    """
    both = frames.merge(motion, on=["clip_id", "frame"]).sort_values(["clip_id", "frame"])
    both = both[both["valid"].astype(bool)].reset_index(drop=True)
    told = both[list(ACTIONS)].fillna(False).to_numpy(bool)
    not_told = ~both[list(ACTIONS)].fillna(True).to_numpy(bool)
    borders = np.append(run_starts(both), len(both))
    found = []
    for track, (gaze, head, others) in FOLLOWS.items():
        angle, follower = (both[name].to_numpy("float64") for name in (gaze, head))
        still = not_told[:, _columns(others)].all(axis=1)
        for action in track_actions(track):
            on = told[:, _columns([action])[0]]
            starts = run_starts(both, on)
            for first, last in pairwise([*starts, len(both)]):
                end = borders[np.searchsorted(borders, first, "right")]  # of these frames
                if not on[first] or last - first < LEAST_HELD or last + LAG > end:
                    continue
                if not still[first : last + LAG].all():
                    continue
                held = slice(first + ONSET, last - OFFSET)
                later = slice(held.start + LAG, held.stop + LAG)
                own = angle[held].mean(), follower[later].mean()
                found.append((both["clip_id"].iat[first], track, action, *own))
    table = pd.DataFrame(found, columns=["clip_id", "track", "action", "gaze", "head"])
    return table.dropna(ignore_index=True)


def _columns(actions: Sequence[str]) -> list[int]:
    return [list(ACTIONS).index(action) for action in actions]


def drift(gazes: pd.DataFrame, clips: Sequence[str], weights: np.ndarray) -> np.ndarray | None:
    """The slope of the head's angle on the eyes', (1 + resamples,); radians per radian.

    gazes: of `gazes`, of these clips. weights (1 + resamples, n_clips): of `resampled`. The slope
    is within each direction, so that what a timeline tells is out of it; an axis counts by how sure
    its slope is. None where no axis has LEAST_GAZES.

    It is a little flatter than the law behind it, since eyes also move by themselves, and no head
    with them: what it is to be compared with is the slope of real clips.
    """
    slopes, precisions = [], []
    for track in FOLLOWS:
        own = gazes[gazes["track"] == track]
        if len(own) < LEAST_GAZES:
            continue
        directions = [_sums(each, clips, weights) for _, each in own.groupby("action")]
        n, xx, xy, yy = np.sum(directions, axis=0)  # (1 + resamples,) each
        with np.errstate(divide="ignore", invalid="ignore"):
            slopes.append(xy / xx)
            rest = np.maximum(yy - xy * xy / xx, yy * np.finfo(float).eps)  # 0 where all lie on it
            precisions.append(xx * (n - 3) / rest)  # 1 / variance of the slope
    if not slopes:
        return None
    return np.average(slopes, axis=0, weights=precisions)


def pulls(frames: pd.DataFrame, narrow: pd.DataFrame, wide: pd.DataFrame) -> pd.DataFrame:
    """Of each gaze (`gazes`), how much farther eyes and head go in one motion than in another.

    narrow, wide: `motion` of the same timelines and the same noise, with eyes that are given and
    go farther in the second.
    """
    first, second = (gazes(frames, own) for own in (narrow, wide))
    angles = ["gaze", "head"]
    return second.assign(**{name: second[name] - first[name] for name in angles})


def pull(pulls: pd.DataFrame, clips: Sequence[str], weights: np.ndarray) -> np.ndarray | None:
    """How much farther the head goes per radian that the eyes do, (1 + resamples,).

    pulls: of `pulls`, of these clips. weights (1 + resamples, n_clips): of `resampled`. The slope
    of a line through no difference at all; None without a gaze that goes farther. Both motions have
    the noise in common, so that what else moves a head is out of it.
    """
    x, y = pulls["gaze"].to_numpy(), pulls["head"].to_numpy()
    by_clip = np.zeros((len(clips), 2))
    np.add.at(by_clip, pd.Index(clips).get_indexer(pulls["clip_id"]), np.stack([x * x, x * y], -1))
    xx, xy = (weights @ by_clip).T
    if not xx[0]:
        return None
    return np.divide(xy, xx, out=np.full(len(xx), np.nan), where=xx > 0)


def _sums(gazes: pd.DataFrame, clips: Sequence[str], weights: np.ndarray) -> np.ndarray:
    """(4, 1 + resamples): number of gazes; squares of x, products and squares of y about the mean.

    x: the eyes' angle, y: the head's.
    """
    x, y = gazes["gaze"].to_numpy(), gazes["head"].to_numpy()
    each = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)
    by_clip = np.zeros((len(clips), 6))
    np.add.at(by_clip, pd.Index(clips).get_indexer(gazes["clip_id"]), each)
    n, sx, sy, sxx, sxy, syy = (weights @ by_clip).T
    share = 1 / np.maximum(n, 1)
    return np.array([n, sxx - sx * sx * share, sxy - sx * sy * share, syy - sy * sy * share])
