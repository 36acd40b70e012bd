"""Motion that follows a timeline."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import torch
from torch import Tensor

from mimeline.diffusion.guidance import Condition, Listen, guided, weighted
from mimeline.diffusion.samplers import Denoiser, sample
from mimeline.generation.request import Request
from mimeline.generation.windows import windowed
from mimeline.models.timeline import TimelineModel
from mimeline.training.checkpoint import load
from mimeline.vocabulary import ACTIONS, CONTROL_REGIONS, UNKNOWN

FRAMES = 2**13  # that are denoised at once, windows and passes of guidance counted: bounds memory


@dataclass(frozen=True)
class Sampling:
    """How a model is asked for motion.

    sampler: a name of SAMPLERS. sampler_steps: calls of the denoiser. guidance: scale of
    classifier-free guidance, 1 for none. region_guidance: scales by control region; where there are
    some, each region is told and guided by itself, those not named at `guidance`.
    guidance_interval: shares of the noise schedule between which guidance is on. overlap: share of
    a window that it has in common with the next, where a timeline is longer than the windows that
    the model was trained on. precision: of the network's arithmetic.
    """

    sampler: str
    sampler_steps: int
    guidance: float
    region_guidance: Mapping[str, float]
    guidance_interval: tuple[float, float]
    overlap: float
    precision: Literal["float32", "bfloat16"]


def generate(
    checkpoint: str | Path, requests: Sequence[Request], sampling: Sampling, seed: int
) -> list[np.ndarray]:
    """Motion for each request, (L, D) float32 in channel units, columns as in the checkpoint.

    Values are held within the range that training has seen. A request's motion depends on the seed
    and its place among the requests, not on the others. Raises BadCheckpoint as `load` does.
    """
    trained = load(checkpoint)
    model = trained.model.to(getattr(torch, sampling.precision))
    window = trained.train["window"]
    made: dict[int, np.ndarray] = {}
    for batch in batches([len(request) for request in requests]):
        own_requests, seeds = [requests[i] for i in batch], [(seed, i) for i in batch]
        scores = sampled(model, own_requests, sampling, window, seeds)
        for i, own in zip(batch, scores, strict=True):
            made[i] = trained.normaliser.undo(own.numpy())
    return [made[i] for i in range(len(requests))]


@torch.inference_mode()
def sampled(
    model: TimelineModel,
    requests: Sequence[Request],
    sampling: Sampling,
    window: int,
    seeds: Sequence[Sequence[int]],
) -> list[Tensor]:
    """Motion as z-scores, (L, D) float32 for each request, all in one batch.

    window: frames of the windows that the model was trained on. seeds: numbers for each request
    that settle its noise. The model is in sampling.precision.
    """
    lengths = [len(request) for request in requests]
    valid = torch.arange(max(lengths)) < torch.tensor(lengths)[:, None]  # (B, L)
    left = padded([request.left for request in requests])  # (B, L, 16)
    right = padded([request.right for request in requests])  # (B, L, 16)
    noise = Noise(lengths, len(model.channels), seeds)
    listen = windowed(model.listen, window, round(sampling.overlap * window))
    denoise = guided(
        two_sided(listen, model.channels),
        [(*told, valid) for told in tellings(left, right, sampling.region_guidance)],
        (torch.full_like(left, UNKNOWN), torch.full_like(right, UNKNOWN), valid),
        scales(sampling),
        steps_between(sampling.guidance_interval, len(model.schedule)),
    )
    made = sample(sampling.sampler, denoise, noise(), model.schedule, sampling.sampler_steps, noise)
    return [own[:length] for own, length in zip(made, lengths, strict=True)]


class Noise:
    """Standard normal noise (B, L, D), anew at each call; each sequence has a seed of its own."""

    def __init__(self, lengths: Sequence[int], channels: int, seeds: Sequence[Sequence[int]]):
        self.shapes = [(length, channels) for length in lengths]
        self.generators = [
            torch.Generator().manual_seed(int(np.random.SeedSequence(seed).generate_state(1)[0]))
            for seed in seeds
        ]

    def __call__(self) -> Tensor:
        drawn = [
            torch.randn(shape, generator=generator)
            for shape, generator in zip(self.shapes, self.generators, strict=True)
        ]
        return torch.nn.utils.rnn.pad_sequence(drawn, batch_first=True)  # (B, L, D)


def two_sided(listen: Listen, channels: Sequence[str]) -> Listen:
    """A model that listens to a timeline for each half of the face, (left, right, valid).

    A sided channel follows its half's, one without a side the mean of what both make of it. The
    halves are denoised together, so that they agree on all that is not told apart.
    """
    share = torch.tensor([_left_share(name) for name in channels])  # (D,)

    def listen_both(left: Tensor, right: Tensor, valid: Tensor) -> Denoiser:
        if torch.equal(left, right):
            return listen(left, valid)
        return weighted(listen, [(left, valid), (right, valid)], [share, 1 - share])

    return listen_both


def tellings(left: Tensor, right: Tensor, apart: Mapping[str, float]) -> Iterator[Condition]:
    """(left, right) with all that is asked; where regions are guided apart, region by region."""
    if not apart:
        yield left, right
        return
    regions = [action.control_region for action in ACTIONS.values()]
    for region in CONTROL_REGIONS:
        others = torch.tensor([own != region for own in regions])  # (16,)
        yield left.masked_fill(others, UNKNOWN), right.masked_fill(others, UNKNOWN)


def scales(sampling: Sampling) -> list[float]:
    """The scale of each of the `tellings`."""
    if not sampling.region_guidance:
        return [sampling.guidance]
    return [sampling.region_guidance.get(r, sampling.guidance) for r in CONTROL_REGIONS]


def steps_between(shares: tuple[float, float], steps: int) -> tuple[int, int] | None:
    """The first and the last step of an interval given as shares of the schedule; None: all."""
    if tuple(shares) == (0, 1):
        return None
    return tuple(round(share * (steps - 1)) for share in shares)


def padded(timelines: Sequence[np.ndarray]) -> Tensor:
    """Timelines (L, 16) as (B, longest L, 16), unknown after their ends."""
    parts = [torch.from_numpy(np.asarray(timeline, np.float32)) for timeline in timelines]
    return torch.nn.utils.rnn.pad_sequence(parts, batch_first=True, padding_value=UNKNOWN)


def batches(lengths: Sequence[int]) -> Iterator[list[int]]:
    """Indices of requests of like length, so many at once as FRAMES allows."""
    batch: list[int] = []
    for i in sorted(range(len(lengths)), key=lambda i: -lengths[i]):
        if batch and (len(batch) + 1) * lengths[batch[0]] > FRAMES:
            yield batch
            batch = []
        batch.append(i)
    if batch:
        yield batch


def _left_share(channel: str) -> float:
    if channel.endswith("Left"):
        return 1.0
    return 0.0 if channel.endswith("Right") else 0.5
