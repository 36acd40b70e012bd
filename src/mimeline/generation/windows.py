"""Sequences of any length from a model of short ones: windows that agree where they overlap."""

import torch
from torch import Tensor

from mimeline.diffusion.guidance import Listen
from mimeline.diffusion.samplers import Denoiser

FRAMES = 2**14  # of windows that are denoised at once: bounds memory


def windowed(listen: Listen, window: int, overlap: int) -> Listen:
    """A model that listens to whole sequences, and denoises them in windows.

    At each diffusion step the windows are denoised side by side and their predictions are faded
    into each other, so that the next step starts from one sequence (Bar-Tal et al. 2023, equation
    5): there is no seam to hide afterwards.

    listen: of conditions (N, window, ...), the last of them valid (N, window) bool. overlap: least
    number of frames that neighbours share. The sequences' own valid (B, L) ends with their last
    frame; each has windows of its own, so that none depends on the others.
    """

    def listen_long(*condition: Tensor) -> Denoiser:
        valid = condition[-1]  # (B, L)
        width = min(window, valid.shape[1])
        common = min(overlap, width - 1)
        row, frame = windows(last_frames(valid), width, common)  # (N, 1), (N, width)
        own = fade(width, common).expand(frame.shape)  # (N, width)
        total = torch.zeros(valid.shape).index_put((row, frame), own, accumulate=True)
        share = (own / total[row, frame])[..., None]  # (N, width, 1), 1 in all at each frame
        groups = torch.arange(len(row)).split(max(1, FRAMES // width))
        pieces = [apart(row[group]) for group in groups]

        def hear(group: Tensor) -> Denoiser:
            return listen(*(part[row[group], frame[group]] for part in condition))

        heard = hear(groups[0]) if len(groups) == 1 else None  # else it would all lie in memory

        def denoise(noisy: Tensor, step: Tensor) -> Tensor:
            blended = torch.zeros_like(noisy)  # (B, L, D)
            for group, own in zip(groups, pieces, strict=True):
                at = row[group], frame[group]
                clean = (heard or hear(group))(noisy[at], step[at[0][:, 0]])  # (n, width, D)
                for piece in own:  # always in the same order, whatever the threads
                    where = row[group[piece]], frame[group[piece]]
                    blended[where] += share[group[piece]] * clean[piece]
            return blended

        return denoise

    return listen_long


def windows(lengths: Tensor, width: int, overlap: int) -> tuple[Tensor, Tensor]:
    """The windows of sequences (B,): which sequence (N, 1), and which of its frames (N, width)."""
    starts = [window_starts(length, width, overlap) for length in lengths.tolist()]
    row = torch.tensor([i for i, own in enumerate(starts) for _ in own])
    first = torch.tensor([start for own in starts for start in own])
    return row[:, None], first[:, None] + torch.arange(width)


def apart(row: Tensor) -> list[Tensor]:
    """Windows by their place in their sequence: the first of each, the second of each, and so on.

    row (N, 1): the sequence of each, in order. Of one place no two have a frame in common.
    """
    row = row[:, 0]
    place = torch.arange(len(row)) - torch.searchsorted(row, row)  # (N,)
    return [(place == own).nonzero()[:, 0] for own in range(int(place.max()) + 1)]


def window_starts(length: int, width: int, overlap: int) -> list[int]:
    """First frames of the fewest windows that cover the length and overlap so far, spread evenly.

    A sequence that is shorter than the window has one.
    """
    beyond = max(length - width, 0)  # frames behind the first window
    more = -(-beyond // (width - overlap))  # windows behind the first
    return [i * beyond // max(more, 1) for i in range(more + 1)]


def fade(width: int, overlap: int) -> Tensor:
    """(width,) weights that rise over the first frames of an overlap and fall over the last.

    They rise with the square: near its border a window knows the least of what is around a frame.
    """
    ramp = torch.arange(1, width + 1).clamp(max=max(overlap, 1))
    return torch.minimum(ramp, ramp.flip(0)).square().float()


def last_frames(valid: Tensor) -> Tensor:
    """(B,) length of each sequence up to its last valid frame, at least 1; valid (B, L) bool."""
    frame = torch.arange(1, valid.shape[1] + 1)
    return (valid * frame).amax(dim=1).clamp(min=1)
