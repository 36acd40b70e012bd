"""Motion that follows a timeline."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from mimeline.diffusion.guidance import classifier_free
from mimeline.diffusion.samplers import dpmpp_2m
from mimeline.models.timeline import TimelineModel
from mimeline.training.checkpoint import load
from mimeline.vocabulary import UNKNOWN

PAIRS = 2**22  # of frames that attend to each other, in one batch: bounds the memory


def generate(
    checkpoint: str | Path,
    timelines: Sequence[np.ndarray],
    sampler_steps: int,
    guidance: float,
    seed: int,
) -> list[np.ndarray]:
    """Motion for each timeline, (L, D) float32 in channel units, columns as in the checkpoint.

    timelines: (L, 16) each, in {0, 1}, -1 where the model may choose. sampler_steps: calls of the
    denoiser. guidance: scale of classifier-free guidance, 1 for none. Values are held within the
    range that training has seen. Raises BadCheckpoint as `load` does.
    """
    trained = load(checkpoint)
    generator = torch.Generator().manual_seed(seed)
    n_channels = len(trained.normaliser.channels)
    asked = [torch.from_numpy(np.asarray(t, np.float32)) for t in timelines]
    noise = [torch.randn(len(t), n_channels, generator=generator) for t in asked]
    made: dict[int, np.ndarray] = {}
    for batch in batches([len(t) for t in asked]):
        scores = sample(
            trained.model,
            [asked[i] for i in batch],
            [noise[i] for i in batch],
            sampler_steps,
            guidance,
        )
        for i, own in zip(batch, scores, strict=True):
            made[i] = trained.normaliser.undo(own[: len(asked[i])].numpy())
    return [made[i] for i in range(len(asked))]


@torch.inference_mode()
def sample(
    model: TimelineModel,
    timelines: Sequence[Tensor],
    noise: Sequence[Tensor],
    sampler_steps: int,
    guidance: float,
) -> Tensor:
    """Motion as z-scores for timelines (L, 16) from noise (L, D), one padded batch: (B, L, D)."""
    pad = torch.nn.utils.rnn.pad_sequence
    condition = pad(list(timelines), batch_first=True, padding_value=UNKNOWN)  # (B, L, 16)
    start = pad(list(noise), batch_first=True)  # (B, L, D)
    lengths = torch.tensor([len(timeline) for timeline in timelines])
    valid = torch.arange(condition.shape[1]) < lengths[:, None]  # (B, L)
    null = torch.full_like(condition, UNKNOWN)
    denoise = classifier_free(model, condition, null, valid, guidance)
    return dpmpp_2m(denoise, start, model.schedule, sampler_steps)


def batches(lengths: Sequence[int]) -> Iterator[list[int]]:
    """Indices of timelines of like length, so many at once as PAIRS allows."""
    batch: list[int] = []
    for i in sorted(range(len(lengths)), key=lambda i: -lengths[i]):
        if batch and (len(batch) + 1) * lengths[batch[0]] ** 2 > PAIRS:
            yield batch
            batch = []
        batch.append(i)
    if batch:
        yield batch
