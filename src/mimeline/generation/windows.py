"""Sequences of any length from a model of short ones: windows that agree where they overlap."""

import torch
from torch import Tensor

from mimeline.diffusion.guidance import Listen
from mimeline.diffusion.samplers import Denoiser


def windowed(listen: Listen, window: int, overlap: int) -> Listen:
    """A model that listens to whole sequences, and denoises them in windows.

    At each diffusion step all windows are denoised in one batch and their predictions are faded
    into each other, so that the next step starts from one sequence (Bar-Tal et al. 2023, equation
    5): there is no seam to hide afterwards.

    listen: of conditions (N, window, ...), the last of them valid (N, window) bool. overlap: least
    number of frames that neighbours share. The sequences' own valid (B, L) ends with their last
    frame; each has windows of its own, so that none depends on the others.
    """

    def listen_long(*condition: Tensor) -> Denoiser:
        valid = condition[-1]  # (B, L)
        width = min(window, valid.shape[1])
        starts = [window_starts(int(n), width, overlap) for n in last_frames(valid)]
        sequence = torch.tensor([i for i, own in enumerate(starts) for _ in own])  # (N,)
        frame = torch.tensor([s for own in starts for s in own])[:, None] + torch.arange(width)
        at = (sequence[:, None].to(valid.device), frame.to(valid.device))  # (N, width)
        told = listen(*(part[at] for part in condition))
        weight = fade(width, overlap).to(valid.device).expand(len(sequence), width)
        total = torch.zeros(valid.shape, device=valid.device).index_put(at, weight, accumulate=True)

        def denoise(noisy: Tensor, step: Tensor) -> Tensor:
            clean = told(noisy[at], step[at[0][:, 0]])  # (N, width, D)
            share = (weight / total[at])[..., None].to(noisy.dtype)  # (N, width, 1)
            return torch.zeros_like(noisy).index_put(at, share * clean, accumulate=True)

        return denoise

    return listen_long


def window_starts(length: int, window: int, overlap: int) -> list[int]:
    """First frames of as few evenly spread windows as cover the length and overlap so far."""
    if length <= window:
        return [0]
    step = max(window - overlap, 1)
    count = -(-(length - window) // step) + 1
    return [round(i * (length - window) / (count - 1)) for i in range(count)]


def fade(window: int, overlap: int) -> Tensor:
    """(window,) weights that rise over the first frames of an overlap and fall over the last."""
    ramp = torch.arange(1, window + 1).clamp(max=max(overlap, 1))
    return torch.minimum(ramp, ramp.flip(0)).float()


def last_frames(valid: Tensor) -> Tensor:
    """(B,) length of each sequence up to its last valid frame, at least 1; valid (B, L) bool."""
    frame = torch.arange(1, valid.shape[1] + 1, device=valid.device)
    return (valid * frame).amax(dim=1).clamp(min=1)
