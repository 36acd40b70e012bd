"""Clips as arrays for the models: normalised motion, its timeline, and batches of random crops."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
import torch
from torch import Tensor

from mimeline.vocabulary import ACTIONS, UNKNOWN

STD_FLOOR = 1e-3  # a channel that hardly moves is not blown up
MOSTLY = 0.5  # share of frames from which a channel counts as measured


@dataclass(frozen=True)
class Normaliser:
    """The z-score of the training part.

    channels: D names in order. mean, std, low, high: (D,) in channel units; low and high are the
    least and the largest value that the training part holds.
    """

    channels: tuple[str, ...]
    mean: np.ndarray
    std: np.ndarray
    low: np.ndarray
    high: np.ndarray

    @classmethod
    def from_statistics(cls, statistics: pd.DataFrame) -> "Normaliser":
        """From the statistics table; only channels that were mostly measured."""
        rows = statistics[(statistics["measured"] >= MOSTLY) & statistics["std"].notna()]
        mean, std, low, high = (
            rows[name].to_numpy(np.float64) for name in ("mean", "std", "low", "high")
        )
        return cls(tuple(rows["channel"]), mean, np.maximum(std, STD_FLOOR), low, high)

    def apply(self, values: np.ndarray) -> np.ndarray:
        """Channel units → z-scores, (..., D) float32."""
        return ((values - self.mean) / self.std).astype(np.float32)

    def undo(self, scores: np.ndarray) -> np.ndarray:
        """z-scores → channel units, (..., D) float32, held within what training has seen."""
        return (scores * self.std + self.mean).clip(self.low, self.high).astype(np.float32)


@dataclass(frozen=True)
class Clip:
    """motion (L, D) z-scored · timeline (L, 16) in {0, 1}, -1 unknown · valid (L,) bool.

    measured (L, D) bool: whether a value was measured in a frame that was tracked; motion is 0
    elsewhere. A frame is valid where it has a measured channel.
    """

    clip_id: str
    motion: np.ndarray
    timeline: np.ndarray
    valid: np.ndarray
    measured: np.ndarray


@dataclass(frozen=True)
class Batch:
    """Crops of the named clips, padded: motion (B, L, D) · timeline (B, L, 16) · valid (B, L) bool.

    measured (B, L, D) bool: as a clip's.
    """

    clip_ids: tuple[str, ...]
    motion: Tensor
    timeline: Tensor
    valid: Tensor
    measured: Tensor


def timelines(frames: pd.DataFrame) -> dict[str, np.ndarray]:
    """The frames table as clip_id → (L, 16) float32: 1 asked for, 0 absent, -1 not measured."""
    values = frames[list(ACTIONS)].to_numpy(dtype=np.float32, na_value=UNKNOWN)
    return {clip: values[rows] for clip, rows in frames.groupby("clip_id").indices.items()}


def clips(
    motion: pd.DataFrame, frames: pd.DataFrame, normaliser: Normaliser, wanted: Collection[str]
) -> list[Clip]:
    """The wanted clips with at least one valid frame, sorted by clip_id.

    motion, frames: the tables of these names. A frame that lacks some of the normaliser's channels
    is valid, but not one that lacks them all: takes of one project may differ in what they
    measure. A frame without a row in the frames table has an unknown timeline.
    """
    motion = motion[motion["clip_id"].isin(list(wanted))].reset_index(drop=True)
    joined = motion[["clip_id", "frame"]].merge(frames, on=["clip_id", "frame"], how="left")
    timeline = joined[list(ACTIONS)].to_numpy(dtype=np.float32, na_value=UNKNOWN)  # (N, 16)
    scores = normaliser.apply(motion[list(normaliser.channels)].to_numpy(np.float64))  # (N, D)
    measured = motion["valid"].to_numpy(bool)[:, None] & np.isfinite(scores)  # (N, D)
    scores[~measured] = 0.0
    valid = measured.any(axis=1)  # (N,)
    found = []
    for clip, rows in sorted(motion.groupby("clip_id").indices.items()):
        if valid[rows].any():
            parts = (scores[rows], timeline[rows], valid[rows], measured[rows])
            found.append(Clip(str(clip), *parts))
    return found


def collate(crops: Sequence[Clip], length: int) -> Batch:
    """Crops of at most `length` frames as one batch; what is missing at the end is not valid."""
    n_channels, n_actions = crops[0].motion.shape[1], crops[0].timeline.shape[1]
    motion = np.zeros((len(crops), length, n_channels), np.float32)
    timeline = np.full((len(crops), length, n_actions), UNKNOWN, np.float32)
    valid = np.zeros((len(crops), length), bool)
    measured = np.zeros((len(crops), length, n_channels), bool)
    for i, crop in enumerate(crops):
        motion[i, : len(crop.motion)] = crop.motion
        timeline[i, : len(crop.motion)] = crop.timeline
        valid[i, : len(crop.motion)] = crop.valid
        measured[i, : len(crop.motion)] = crop.measured
    ids = tuple(crop.clip_id for crop in crops)
    return Batch(ids, *(torch.from_numpy(x) for x in (motion, timeline, valid, measured)))


def random_batches(
    clips: Sequence[Clip], window: int, batch: int, generator: torch.Generator
) -> Iterator[Batch]:
    """Batches without end: a clip by its length, then a crop of `window` frames anywhere in it.

    A clip shorter than the window is padded. A crop that holds no valid frame is drawn anew.
    """
    weights = torch.tensor([float(clip.valid.sum()) for clip in clips])
    while True:
        crops: list[Clip] = []
        while len(crops) < batch:
            drawn = torch.multinomial(weights, batch, replacement=True, generator=generator)
            where = torch.rand(batch, generator=generator)
            cuts = (
                _crop(clips[i], window, u)
                for i, u in zip(drawn.tolist(), where.tolist(), strict=True)
            )
            crops += [cut for cut in cuts if cut.valid.any()]
        yield collate(crops[:batch], window)


def _crop(clip: Clip, window: int, where: float) -> Clip:
    """The window that starts at the share `where` of [0, 1) of the places where one can start."""
    start = int(where * (max(len(clip.motion) - window, 0) + 1))
    part = slice(start, start + window)
    arrays = (clip.motion, clip.timeline, clip.valid, clip.measured)
    return Clip(clip.clip_id, *(array[part] for array in arrays))
