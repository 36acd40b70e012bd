import itertools
import math

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from mimeline.diffusion.samplers import sample
from mimeline.diffusion.schedule import cosine
from mimeline.generation import windows
from mimeline.generation.windows import fade, last_frames, window_starts, windowed

WINDOW, OVERLAP = 32, 8


def seen(batch: int, length: int) -> torch.Tensor:
    return torch.ones(batch, length, dtype=torch.bool)


def frame_by_frame(told: torch.Tensor, valid: torch.Tensor):
    """A model whose frames know nothing of each other: windows cannot change what it says."""

    def denoise(noisy, step):
        return noisy * 0.5 + told + step[:, None, None]

    return denoise


def drawn(*shape: int) -> torch.Tensor:
    return torch.randn(shape, generator=torch.Generator().manual_seed(0))


@given(st.integers(1, 400), st.integers(1, 50), st.data())
def test_windows_cover_every_frame_overlap_enough_and_lie_evenly(length, width, data):
    overlap = data.draw(st.integers(0, width - 1))
    starts = window_starts(length, width, overlap)
    steps = [after - before for before, after in itertools.pairwise(starts)]
    assert starts[0] == 0
    assert starts[-1] == max(length - width, 0)
    assert all(0 < step <= width - overlap for step in steps)
    assert max(steps, default=0) - min(steps, default=0) <= 1
    fewest = math.ceil(max(length - width, 0) / (width - overlap)) + 1
    assert len(starts) == fewest


@pytest.mark.parametrize("overlap", [0, 1, 8, 20, 31, 32, 99])
@pytest.mark.parametrize("length", [1, 31, 32, 33, 100, 320])
def test_windows_change_nothing_of_what_each_frame_says_by_itself(length, overlap):
    noisy, told, step = drawn(2, length, 3), drawn(2, length, 3), torch.tensor([4, 7])
    valid = seen(2, length)
    whole = frame_by_frame(told, valid)(noisy, step)
    in_windows = windowed(frame_by_frame, WINDOW, overlap)(told, valid)(noisy, step)
    torch.testing.assert_close(in_windows, whole)


def test_a_sequence_has_windows_of_its_own_whatever_is_beside_it():
    """A model in which every frame of a window hears all the others that are valid."""

    def in_company(told, valid):
        shown = valid[..., None]
        return lambda noisy, step: noisy + ((told + noisy) * shown).sum(1, keepdim=True)

    lengths, step = [5, 32, 33, 150], torch.zeros(4, dtype=torch.long)
    noisy, told = drawn(4, 150, 3), drawn(4, 150, 3)
    valid = torch.arange(150) < torch.tensor(lengths)[:, None]
    together = windowed(in_company, WINDOW, OVERLAP)(told, valid)(noisy, step)
    for i, n in enumerate(lengths):
        one = slice(i, i + 1)
        listen = windowed(in_company, WINDOW, OVERLAP)
        alone = listen(told[one, :n], valid[one, :n])(noisy[one, :n], step[one])
        torch.testing.assert_close(together[one, :n], alone)


def test_the_weights_of_a_window_rise_and_fall_over_its_overlaps():
    assert fade(7, 3).tolist() == [1, 4, 9, 9, 9, 4, 1]
    assert fade(4, 0).tolist() == [1, 1, 1, 1]
    assert fade(5, 4).tolist() == [1, 4, 9, 4, 1]


def test_a_sequence_ends_with_its_last_valid_frame_not_with_the_first_that_is_lost():
    valid = torch.tensor([[1, 1, 0, 1, 0], [0, 0, 0, 0, 0], [1, 1, 1, 1, 1]]).bool()
    assert last_frames(valid).tolist() == [4, 1, 5]


def test_no_more_frames_are_denoised_at_once_than_memory_is_for(monkeypatch):
    batches = []

    def counting(told, valid):
        batches.append(valid.numel())
        return frame_by_frame(told, valid)

    noisy, told, step = drawn(3, 500, 2), drawn(3, 500, 2), torch.tensor([1, 2, 3])
    at_once = windowed(counting, WINDOW, OVERLAP)(told, seen(3, 500))(noisy, step)
    assert batches == [3 * 21 * WINDOW]  # heard once
    batches.clear()
    monkeypatch.setattr(windows, "FRAMES", 5 * WINDOW + 1)
    in_groups = windowed(counting, WINDOW, OVERLAP)(told, seen(3, 500))(noisy, step)
    assert max(batches) == 5 * WINDOW
    torch.testing.assert_close(in_groups, at_once)


class Wander:
    """Motion that remembers some ten frames, and the model that knows all about it.

    Its prediction is the exact mean of clean motion given all of the noisy motion that it sees.
    """

    memory = 3.0

    def __init__(self, steps: int):
        self.schedule = cosine(steps)

    def listen(self, valid: torch.Tensor):
        frame = torch.arange(valid.shape[1], dtype=torch.float64)
        apart = (frame[:, None] - frame).abs() / self.memory
        kept = (1 + apart) * torch.exp(-apart)  # (L, L) covariance of a smooth Markov process

        def denoise(noisy, step):
            alpha_bar = self.schedule.alpha_bar[step[0]]
            seen = alpha_bar * kept + (1 - alpha_bar) * torch.eye(len(frame), dtype=torch.float64)
            gain = alpha_bar.sqrt() * torch.linalg.solve(seen, kept).T  # (L, L)
            return gain.to(noisy) @ noisy

        return denoise

    def sample(self, listen, batch: int, length: int) -> torch.Tensor:
        """Motion (B, L, 2) from noise that is the same for the same size."""
        generator = torch.Generator().manual_seed(0)

        def draw() -> torch.Tensor:
            return torch.randn(batch, length, 2, generator=generator)

        denoise = listen(seen(batch, length))
        return sample("dpmpp_2m", denoise, draw(), self.schedule, len(self.schedule), draw)


PIECES = 4
LENGTH = PIECES * (WINDOW - OVERLAP) + OVERLAP
STARTS = window_starts(LENGTH, WINDOW, OVERLAP)
SHARED = [frame for start in STARTS[1:] for frame in range(start, start + OVERLAP)]
WANDER = Wander(steps=20)


def near(values: torch.Tensor, frames: list[int]) -> float:
    """Spread of values (B, L, D) in these frames, as a share of their spread in the others."""
    here = torch.zeros(values.shape[1], dtype=torch.bool)
    here[frames] = True
    return (values[:, here].std() / values[:, ~here].std()).item()


def seams(motion: torch.Tensor, borders: list[int]) -> tuple[float, float]:
    """Spread of velocity and of acceleration over borders, as a share of that elsewhere."""
    velocity, before = motion.diff(dim=1), [border - 1 for border in borders]
    return near(velocity, before), near(velocity.diff(dim=1), before)


@pytest.fixture(scope="module")
def pieces() -> list[torch.Tensor]:
    """Windows that know nothing of each other."""
    return list(WANDER.sample(WANDER.listen, PIECES * 400, WINDOW).split(400))


def test_motion_in_windows_is_as_fast_and_as_wide_at_their_borders_as_elsewhere():
    made = WANDER.sample(windowed(WANDER.listen, WINDOW, OVERLAP), 400, LENGTH)
    borders = [border for start in STARTS[1:] for border in (start, start + OVERLAP)]
    assert seams(made, borders) == pytest.approx((1, 1), abs=0.04)
    assert near(made, SHARED) == pytest.approx(1, abs=0.04)


def test_windows_that_are_joined_jump(pieces):
    joined = torch.cat(pieces, dim=1)
    assert min(seams(joined, [i * WINDOW for i in range(1, PIECES)])) > 2


def test_windows_without_overlap_jump_less_than_joined_ones_but_do():
    made = WANDER.sample(windowed(WANDER.listen, WINDOW, 0), 400, PIECES * WINDOW)
    assert min(seams(made, [i * WINDOW for i in range(1, PIECES)])) > 1.3


def test_windows_that_are_faded_into_each_other_when_they_are_done_lose_their_strength(pieces):
    weight, total, made = fade(WINDOW, OVERLAP), torch.zeros(LENGTH), torch.zeros(400, LENGTH, 2)
    for start, piece in zip(STARTS, pieces, strict=True):
        total[start : start + WINDOW] += weight
        made[:, start : start + WINDOW] += weight[:, None] * piece
    assert near(made / total[:, None], SHARED) < 0.9
