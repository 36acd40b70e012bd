"""Motion that follows a timeline."""

import logging
from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from itertools import chain
from typing import Literal

import numpy as np
import torch
from torch import Tensor
from torch.nn.utils.rnn import pad_sequence

from mimeline.config import checked
from mimeline.dataset.windows import Normaliser
from mimeline.diffusion.guidance import Condition, Listen, between, guided
from mimeline.diffusion.samplers import Denoiser, sample
from mimeline.generation import windows
from mimeline.generation.request import Request
from mimeline.generation.sides import two_sided
from mimeline.generation.windows import windowed
from mimeline.models.divisions import parts
from mimeline.models.timeline import TimelineModel
from mimeline.progress import Pace
from mimeline.timeline.timeline import SIDES, Timeline
from mimeline.training.checkpoint import Trained
from mimeline.vocabulary import ACTIONS, UNKNOWN

log = logging.getLogger(__name__)

FRAMES = windows.FRAMES // 4  # of a batch: with windows, sides and guidance about all at once


@dataclass(frozen=True)
class Sampling:
    """How a model is asked for motion.

    sampler: a name of SAMPLERS. sampler_steps: calls of the denoiser. guidance: scale of
    classifier-free guidance, 1 for none. region_guidance: scales by control region, of those that
    weigh more or less than `guidance`. guidance_interval: shares of the noise schedule between
    which guidance is on. overlap: share of a window that it has in common with the next, where a
    timeline is longer than the windows that the model was trained on. precision: of the network's
    arithmetic. Raises BadConfig where a value is none that evaluate.timeline may have.
    """

    sampler: str
    sampler_steps: int
    guidance: float
    region_guidance: Mapping[str, float]
    guidance_interval: tuple[float, float]
    overlap: float
    precision: Literal["float32", "bfloat16"]

    def __post_init__(self):
        checked({"evaluate": {"timeline": dict(vars(self))}}, "the sampling")


def generate(
    trained: Trained, requests: Sequence[Request | Timeline], sampling: Sampling, seed: int
) -> list[np.ndarray]:
    """Motion for each request, (L, D) float32 in channel units, columns as the model's channels.

    Values are held within the range that training has seen. A request's motion depends on the seed
    and its place among the requests, not on the others. What is asked of a region that the model
    does not move is left out, and so is what is known of a channel that it does not have: the log
    says so.
    """
    requests = [Request.of(own) if isinstance(own, Timeline) else own for own in requests]
    if lost := unheard(requests, trained.normaliser.channels):
        log.warning("the model does not move what %s would: left out", ", ".join(lost))
    if lost := sorted({*chain(*(own.known for own in requests))} - {*trained.normaliser.channels}):
        log.warning("the model does not have %s: what is known is left out", ", ".join(lost))
    model = deepcopy(trained.model).to(getattr(torch, sampling.precision))
    window = trained.train["window"]
    made: dict[int, np.ndarray] = {}
    groups = [*batches([len(request) for request in requests])]
    calls = len(model.schedule) if sampling.sampler == "ddpm" else sampling.sampler_steps
    pace = Pace(calls * len(groups), "steps of the sampler", log)
    for batch in groups:
        own_requests, seeds = [requests[i] for i in batch], [(seed, i) for i in batch]
        known = [known_scores(request, trained.normaliser) for request in own_requests]
        scores = sampled(model, own_requests, sampling, window, seeds, known, pace)
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
    known: Sequence[Tensor] = (),
    pace: Pace | None = None,
) -> list[Tensor]:
    """Motion as z-scores, (L, D) float32 for each request, all in one batch.

    window: frames of the windows that the model was trained on. seeds: numbers for each request
    that settle its noise. known: of `known_scores`, for each request, or none. pace: is told each
    call of the denoiser. The model is in sampling.precision.
    """
    lengths = [len(request) for request in requests]
    valid = torch.arange(max(lengths)) < torch.tensor(lengths)[:, None]  # (B, L)
    deaf = deaf_to(model.channels)  # (16,)
    left, right = (
        padded([getattr(request, side) for request in requests]).masked_fill(deaf, UNKNOWN)
        for side in SIDES
    )  # (B, L, 16) each
    noise = Noise(lengths, len(model.channels), seeds)
    listen = windowed(model.listen, window, round(sampling.overlap * window))
    listen = two_sided(listen, model.channels)
    denoise = obeying(listen, (left, right, valid), sampling, len(model.schedule))
    if any(own.isfinite().any() for own in known):
        denoise = knowing(denoise, pad_sequence(known, batch_first=True, padding_value=torch.nan))
    denoise = denoise if pace is None else paced(denoise, pace)
    made = sample(sampling.sampler, denoise, noise(), model.schedule, sampling.sampler_steps, noise)
    return [own[:length] for own, length in zip(made, lengths, strict=True)]


def obeying(listen: Listen, told: Condition, sampling: Sampling, steps: int) -> Denoiser:
    """The denoiser null + g (told − null) + Σ (g_r − g) (told of r alone − null), r a region.

    told: left, right (B, L, 16) and valid (B, L). g, g_r: the scales of guidance and of
    region_guidance; where no region has one, this is Ho & Salimans 2022, equation 6. A sum over
    regions each told alone (Liu et al. 2022, equation 11) would not know how they go together.
    steps: of the noise schedule. Outside the interval the denoiser is simply told
    (Kynkäänniemi et al. 2024, equation 6).
    """
    left, right, valid = told
    scale, apart = sampling.guidance, sampling.region_guidance
    conditions = [told, *((only(r, left), only(r, right), valid) for r in apart)]
    null = (torch.full_like(left, UNKNOWN), torch.full_like(right, UNKNOWN), valid)
    scales = [scale, *(own - scale for own in apart.values())]
    strong = guided(listen, conditions, null, scales)
    if tuple(sampling.guidance_interval) == (0, 1):
        return strong
    first, last = (round(share * (steps - 1)) for share in sampling.guidance_interval)
    return between(first, last, strong, listen(*told))


def knowing(denoise: Denoiser, known: Tensor) -> Denoiser:
    """The denoiser that predicts what is known, (B, L, D), and the rest where that is NaN.

    So a sampler takes what is known through all levels of noise, and at each of them the model
    sees the rest beside it (imputation; Song et al. 2021b, appendix I.2).
    """
    given = known.isfinite()  # (B, L, D)

    def denoise_rest(noisy: Tensor, step: Tensor) -> Tensor:
        return torch.where(given, known, denoise(noisy, step))

    return denoise_rest


def paced(denoise: Denoiser, pace: Pace) -> Denoiser:
    """The denoiser that tells a pace of its calls."""

    def denoise_and_tell(noisy: Tensor, step: Tensor) -> Tensor:
        clean = denoise(noisy, step)
        pace.step()
        return clean

    return denoise_and_tell


def known_scores(request: Request, normaliser: Normaliser) -> Tensor:
    """(L, D) z-scores of what a request knows, NaN for what the model is to make."""
    unknown = np.full(len(request), np.nan)
    columns = [request.known.get(channel, unknown) for channel in normaliser.channels]
    return torch.from_numpy(normaliser.apply(np.stack(columns, axis=-1)))


def only(region: str, timelines: Tensor) -> Tensor:
    """Timelines (B, L, 16) that tell of a control region and of no other."""
    others = torch.tensor([action.control_region != region for action in ACTIONS.values()])
    return timelines.masked_fill(others, UNKNOWN)


def deaf_to(channels: Sequence[str]) -> Tensor:
    """(16,) bool: the actions of which a model of these channels can have learnt nothing.

    They are those of a region without a channel: told of them, it would do anything.
    """
    moved = parts(channels, "regions")
    return torch.tensor([action.control_region not in moved for action in ACTIONS.values()])


def unheard(requests: Sequence[Request], channels: Sequence[str]) -> list[str]:
    """The actions that requests ask for in vain, of a model of these channels."""
    asked = torch.zeros(len(ACTIONS), dtype=torch.bool)
    for request in requests:
        asked |= torch.from_numpy((np.maximum(request.left, request.right) == 1).any(axis=0))
    return [action for action, lost in zip(ACTIONS, asked & deaf_to(channels), strict=True) if lost]


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
        return pad_sequence(drawn, batch_first=True)  # (B, L, D)


def padded(timelines: Sequence[np.ndarray]) -> Tensor:
    """Timelines (L, 16) as (B, longest L, 16), unknown after their ends."""
    tensors = [torch.from_numpy(timeline) for timeline in timelines]
    return pad_sequence(tensors, batch_first=True, padding_value=UNKNOWN)


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
