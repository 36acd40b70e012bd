"""Pairs of clips that move alike: to the digit, as copies of a take do, or as copies of a film."""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from mimeline.vocabulary import CHANNELS

DIGITS = 3  # of a channel: numbers that were written with fewer digits round to the same
SAME = 2e-3  # of a channel: how far rounding takes two writings of one number apart
LEAST_MOVING = 3  # channels; a frame in which fewer change may be a face at rest, or a repetition
LEAST_FRAMES = 2  # that two takes have in common before a closer look at them
LAG = 8  # of the takes with an equal frame, each is compared with so many others
MOVES = 0.02  # standard deviation of a channel that is more than jitter
# Mean correlation of the channels at the best of three seconds of offsets: of two faces it is .2 at
# most, of one that was tracked twice, with noise of a twentieth of a channel's range, .7 or more.
ALIKE = 0.4


class Motion:
    """The motion table, clip by clip.

    motion: sorted by clip_id and frame, as the table is.
    """

    def __init__(self, motion: pd.DataFrame):
        self.table = motion
        self.clip, self.names = pd.factorize(motion["clip_id"])
        edges = np.searchsorted(self.clip, np.arange(len(self.names) + 1))
        self._rows = {name: slice(*edges[at : at + 2]) for at, name in enumerate(self.names)}

    def values(self, clip_id: str, mirrored: bool = False) -> np.ndarray:
        """Channels by frame from 0, (n, 57); NaN where nothing was measured."""
        rows = self.table.iloc[self._rows.get(clip_id, slice(0))]
        n_frames = int(rows["frame"].max()) + 1 if len(rows) else 0
        values = np.full((n_frames, len(CHANNELS)), np.nan)
        seen = rows[rows["valid"].to_numpy(bool)]
        values[seen["frame"]] = seen[list(CHANNELS)]
        if mirrored:
            names = list(CHANNELS)
            source = [names.index(channel.mirror) for channel in CHANNELS.values()]
            values = values[:, source] * [channel.mirror_sign for channel in CHANNELS.values()]
        return values


def alike_motion(motion: Motion, groups: pd.Series, least_share: float) -> pd.DataFrame:
    """Pairs of clips of different groups with the same numbers, frame by frame at one offset.

    groups: clip_id → a name; clips of one group are not compared. least_share: a pair has more than
    that share of the moving frames of the clip that has fewer of them. Frames in which hardly
    anything changes do not count, nor does a channel that one of the two does not have.
    Returns clip_id, other_id, share, offset_s (NaN), mirrored.
    """
    group = pd.factorize(groups.reindex(motion.names))[0]  # (n_clips,); -1: not asked for
    digest, mirror, moving = _digests(motion)
    moving &= group[motion.clip] >= 0
    pairs = []
    for a, b, offset, mirrored in _candidates(motion, digest, mirror, moving, group):
        one, other = motion.names[a], motion.names[b]
        share = _same_share(motion.values(one), motion.values(other, mirrored), offset)
        if share > least_share:
            pairs.append((one, other, share, mirrored))
    table = pd.DataFrame(pairs, columns=["clip_id", "other_id", "share", "mirrored"])
    table = table.sort_values(["clip_id", "other_id", "share"], ascending=[True, True, False])
    return table.drop_duplicates(["clip_id", "other_id"], ignore_index=True)


def moves_alike(
    one: np.ndarray, other: np.ndarray, offsets: range, least_frames: int
) -> bool | None:
    """Whether two clips show one performance: their channels rise and fall together.

    one, other: (n, 57), (m, 57) as Motion.values gives them. offsets: frames by which other is
    tried against one. None where they have too little in common to tell.
    """
    best = None
    for offset in offsets:
        a, b = _overlap(one, other, offset)
        if len(a) < least_frames:
            continue
        known = np.isfinite(a) & np.isfinite(b)
        a, b = np.where(known, a, np.nan), np.where(known, b, np.nan)
        enough = known.sum(axis=0) >= least_frames
        a, b = a[:, enough], b[:, enough]
        a, b = a - np.nanmean(a, axis=0), b - np.nanmean(b, axis=0)
        spread = np.sqrt(np.nanmean(a**2, axis=0)), np.sqrt(np.nanmean(b**2, axis=0))
        moves = (spread[0] >= MOVES) & (spread[1] >= MOVES)
        if moves.sum() < LEAST_MOVING:
            continue
        r = np.nanmean((a * b)[:, moves], axis=0) / (spread[0] * spread[1])[moves]
        best = max(best if best is not None else -1.0, float(r.mean()))
    return None if best is None else best >= ALIKE


def _digests(motion: Motion) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A number for each row's values, one for those of its mirrored face, and whether it moves."""
    rng = np.random.default_rng(0)
    weight = dict(zip(CHANNELS, rng.integers(1, 2**63, (len(CHANNELS), 2)), strict=True))
    digest, mirror = np.zeros((2, len(motion.clip)), np.int64)
    changed = np.zeros(len(motion.clip), np.int64)
    first = np.diff(motion.clip, prepend=-1) != 0
    for name, channel in CHANNELS.items():
        column = motion.table[name].to_numpy(np.float64)
        known = np.isfinite(column)
        number = np.rint(np.where(known, column, 0) * 10**DIGITS).astype(np.int64)
        value, there = weight[name]
        digest += number * value + known * there
        value, there = weight[channel.mirror]
        mirror += channel.mirror_sign * number * value + known * there
        changed += (np.diff(number, prepend=0) != 0) & known & np.roll(known, 1)
    valid = motion.table["valid"].to_numpy(bool)
    return digest, mirror, valid & ~first & (changed >= LEAST_MOVING)


def _candidates(
    motion: Motion, digest: np.ndarray, mirror: np.ndarray, moving: np.ndarray, group: np.ndarray
) -> Iterator[tuple[int, int, int, bool]]:
    """Clips a < b by number that have equal rows at an offset, in frames."""
    at = np.flatnonzero(moving)
    frame = motion.table["frame"].to_numpy()[at]
    clip = motion.clip[at]
    for mirrored in (False, True):
        # a mirrored row stands beside the rows that it may equal, the plain ones of other clips
        key = np.concatenate([digest[at], mirror[at]]) if mirrored else digest[at]
        flag = np.repeat([False, True], len(at)) if mirrored else np.zeros(len(at), bool)
        row = np.tile(np.arange(len(at)), 2) if mirrored else np.arange(len(at))
        order = np.argsort(key, kind="stable")
        key, flag, row = key[order], flag[order], row[order]
        met = []
        for lag in range(1, LAG + 1):
            i, j = row[:-lag], row[lag:]
            equal = (key[:-lag] == key[lag:]) & (group[clip[i]] != group[clip[j]])
            equal &= (flag[:-lag] != flag[lag:]) if mirrored else True
            i, j = i[equal], j[equal]
            i, j = np.where(clip[i] < clip[j], i, j), np.where(clip[i] < clip[j], j, i)
            met.append(np.stack([clip[i], clip[j], frame[j] - frame[i]], axis=1))
        triples, counts = np.unique(np.concatenate(met), axis=0, return_counts=True)
        for (a, b, offset), count in zip(triples.tolist(), counts, strict=True):
            if count >= LEAST_FRAMES:
                yield a, b, offset, mirrored


def _overlap(one: np.ndarray, other: np.ndarray, offset: int) -> tuple[np.ndarray, np.ndarray]:
    """Frames that stand side by side where other's frame t + offset meets one's frame t."""
    start, end = max(0, -offset), min(len(one), len(other) - offset)
    return one[start : max(start, end)], other[start + offset : max(start, end) + offset]


def _moving(values: np.ndarray) -> np.ndarray:
    """Frames (n,) bool in which enough channels change."""
    steps = np.abs(np.diff(values, axis=0, prepend=values[:1])) >= 0.5 * 10**-DIGITS
    return steps.sum(axis=1) >= LEAST_MOVING


def _same_share(one: np.ndarray, other: np.ndarray, offset: int) -> float:
    """Share of the moving frames, of the clip with fewer, that are the same in every channel."""
    fewer = min(_moving(one).sum(), _moving(other).sum())
    a, b = _overlap(one, other, offset)
    both = np.isfinite(a) & np.isfinite(b)
    same = ((np.abs(a - b) <= SAME) | ~both).all(axis=1) & (both.sum(axis=1) >= LEAST_MOVING)
    return min(1.0, float((same & _moving(a)).sum() / fewer)) if fewer else 0.0
