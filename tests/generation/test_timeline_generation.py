import logging
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
import torch

from mimeline.errors import BadConfig
from mimeline.generation import windows
from mimeline.generation.request import Request
from mimeline.generation.timeline import FRAMES, batches, generate, obeying, sampled
from mimeline.models.timeline import TimelineModel
from mimeline.timeline.timeline import Interval, Timeline
from mimeline.vocabulary import ACTIONS, CONTROL_REGIONS, UNKNOWN, region_actions

ORDER = list(ACTIONS)
WINDOW = 16  # of the checkpoint
NULL = np.full((9, 16), UNKNOWN)


def timelines(*lengths: int) -> list[np.ndarray]:
    rng = np.random.default_rng(0)
    return [rng.integers(0, 2, (length, 16)).astype(np.float32) for length in lengths]


def asked(*lengths: int) -> list[Request]:
    return [Request.both_sides(values) for values in timelines(*lengths)]


def asking(action: str, length: int = 40, side: str | None = None) -> Request:
    """Nothing but an action, on from a quarter to three quarters."""
    halves = {half: np.zeros((length, 16)) for half in ("left", "right")}
    for half, values in halves.items():
        if side in (None, half):
            values[length // 4 : -length // 4, ORDER.index(action)] = 1
    return Request(**halves)


@pytest.fixture
def made(lively, sampling):
    """What the lively model makes of requests, one array each; seeds by their place."""

    def make(requests, **changes) -> list[np.ndarray]:
        seeds = [(0, i) for i in range(len(requests))]
        scores = sampled(lively, requests, sampling(**changes), WINDOW, seeds)
        return [own.numpy() for own in scores]

    return make


# Lengths, ranges, seeds


@pytest.mark.parametrize("sampler", ["ddpm", "ddim", "dpmpp_2m"])
def test_each_request_gets_motion_of_its_own_length(made, sampler):
    lengths = (1, WINDOW - 1, WINDOW, WINDOW + 1, 10 * WINDOW)
    found = made(asked(*lengths), sampler=sampler)
    assert [motion.shape for motion in found] == [(length, 5) for length in lengths]
    assert all(np.isfinite(motion).all() for motion in found)


def test_motion_stays_within_what_training_has_seen(trained, sampling):
    motion = np.concatenate(generate(trained, asked(60), sampling(guidance=8.0), seed=0))
    assert motion.min() == pytest.approx(0.3)
    assert motion.max() == pytest.approx(0.5)


def test_what_is_known_stays_and_the_rest_goes_with_it(trained, sampling):
    (values,) = timelines(3 * WINDOW)
    rise = np.linspace(0.3, 0.5, len(values))
    requests = [Request(values, values, known) for known in ({}, {"head_yaw_left": rise})]
    free, bound = (generate(trained, [own], sampling(), seed=0)[0] for own in requests)
    np.testing.assert_allclose(bound[:, 4], rise, atol=1e-6)
    assert np.abs(bound[:, :4] - free[:, :4]).max() > 0.01
    both = generate(trained, [requests[1], *asked(7)], sampling(), seed=0)
    np.testing.assert_allclose(both[0], bound, atol=1e-5)  # whatever others know


def test_what_is_known_of_a_channel_that_the_model_lacks_is_told(trained, sampling, caplog):
    (values,) = timelines(9)
    knowing = Request(values, values, {"tongueOut": np.zeros(9)})
    (found,) = generate(trained, [knowing], sampling(), seed=0)
    (without,) = generate(trained, [Request(values, values)], sampling(), seed=0)
    np.testing.assert_array_equal(found, without)
    assert "the model does not have tongueOut" in caplog.text


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"sampler": "euler"}, "key evaluate.timeline.sampler: found 'euler'"),
        ({"guidance_interval": (0.9, 0.1)}, "guidance_interval to begin before it ends"),
        ({"overlap": 1.0}, "overlap: found 1.0, expected less than 1"),
        ({"precision": "float16"}, "'float32' or 'bfloat16'"),
    ],
)
def test_a_sampling_that_cannot_be_is_refused(sampling, changes, told):
    with pytest.raises(BadConfig, match=told):
        replace(sampling(), **changes)


def test_a_timeline_is_a_request(trained, sampling):
    smile = Timeline("mine", Fraction(25), 20, {"mouth": [Interval("Smile", 5, 15)]})
    made = [generate(trained, [own], sampling(), seed=0)[0] for own in (smile, Request.of(smile))]
    np.testing.assert_array_equal(*made)


def test_a_seed_settles_the_motion(trained, sampling):
    one, two, other = (generate(trained, asked(9), sampling(), seed)[0] for seed in (3, 3, 4))
    assert np.array_equal(one, two)
    assert not np.array_equal(one, other)


def test_the_same_request_in_two_places_gets_two_motions(trained, sampling):
    first, second = generate(trained, asked(9) * 2, sampling(), seed=0)
    assert not np.allclose(first, second, atol=0.01)


@pytest.mark.parametrize(
    "changes",
    [{}, {"sampler": "ddpm"}, {"region_guidance": {"mouth": 4.0}}, {"guidance_interval": (0.2, 1)}],
    ids=str,
)
def test_a_request_s_motion_does_not_depend_on_its_company(made, changes):
    plain, long, short = asked(20, 50, 3)
    sided = asking("BrowUp", side="left")
    together = made([plain, long, sided, short], **changes)
    assert together[0] == pytest.approx(made([plain], **changes)[0], abs=1e-4)
    assert made([plain, sided], **changes)[0] == pytest.approx(together[0], abs=1e-4)
    assert made([long, sided], **changes)[0].shape == together[1].shape
    (_, among) = made([long, long], **changes)
    assert among == pytest.approx(together[1], abs=1e-4)


def test_batches_do_not_change_the_motion(trained, sampling, monkeypatch):
    requests = asked(20, 9, 50, 3)
    together = generate(trained, requests, sampling(), seed=0)
    monkeypatch.setattr("mimeline.generation.timeline.FRAMES", 1)
    one_by_one = generate(trained, requests, sampling(), seed=0)
    for ours, theirs in zip(together, one_by_one, strict=True):
        assert ours == pytest.approx(theirs, abs=1e-4)


def test_a_batch_holds_requests_of_like_length_and_no_more_frames_than_memory_is_for():
    lengths = [100, 30_000, 2000, 100, *[90] * 60]
    found = list(batches(lengths))
    assert sorted(i for batch in found for i in batch) == list(range(64))
    assert found[0] == [1]
    assert all(len(b) == 1 or len(b) * max(lengths[i] for i in b) <= FRAMES for b in found)


def test_long_work_says_what_is_left(trained, sampling, monkeypatch, caplog):
    monkeypatch.setattr("mimeline.progress.EVERY_S", 0)
    monkeypatch.setattr("mimeline.generation.timeline.FRAMES", 1)
    with caplog.at_level(logging.INFO):
        generate(trained, asked(9, 9), sampling(sampler_steps=3), seed=0)
    said = [text.split(",")[0] for text in caplog.messages if "left" in text.split()[-1]]
    assert said[-5:] == [f"{n} of 6 steps of the sampler" for n in range(1, 6)]


def test_no_request_gives_no_motion(trained, sampling):
    assert generate(trained, [], sampling(), seed=0) == []


# Every key of the sampling says something


@pytest.mark.parametrize(
    "changes",
    [
        {"sampler": "ddpm"},
        {"sampler": "ddim"},
        {"sampler_steps": 5},
        {"guidance": 1.0},
        {"region_guidance": {"brow": 3.0}},
        {"guidance_interval": (0.0, 0.5)},
        {"overlap": 0.5},
    ],
    ids=str,
)
def test_every_key_of_the_sampling_changes_the_motion(made, changes):
    (before,), (after,) = made(asked(50)), made(asked(50), **changes)
    assert np.abs(before - after).max() > 0.01


def test_bfloat16_makes_nearly_the_same_motion(trained, sampling):
    exact, rough = (
        generate(trained, asked(20), sampling(precision=precision), seed=0)[0]
        for precision in ("float32", "bfloat16")
    )
    assert rough.dtype == np.float32
    assert 0 < np.abs(exact - rough).mean() < 0.05


def test_ddpm_takes_fresh_noise_and_the_others_do_not(lively, sampling, monkeypatch):
    draws = []
    randn = torch.randn
    monkeypatch.setattr(torch, "randn", lambda *a, **k: draws.append(a) or randn(*a, **k))
    for sampler, expected in (("ddpm", 4), ("ddim", 1), ("dpmpp_2m", 1)):
        draws.clear()
        sampled(lively, asked(9), sampling(sampler=sampler), WINDOW, [(0,)])
        assert len(draws) == expected, sampler


# Guidance


def echo(told, right, valid):
    """A model in whose column r is how much of region r it is told, plus the step's number."""
    columns = [[ORDER.index(a) for a in region_actions(region)] for region in CONTROL_REGIONS]
    shares = [(told[..., own] != UNKNOWN).float().mean(dim=-1) for own in columns]

    def denoise(noisy, step):
        return torch.stack(shares, dim=-1)  # (B, L, 5)

    return denoise


def scales_of(sampling, step: int = 50, steps: int = 101) -> list[float]:
    """How much each region's timeline counts."""
    told = torch.zeros(1, 4, 16)
    denoise = obeying(echo, (told, told, torch.ones(1, 4, dtype=torch.bool)), sampling, steps)
    return denoise(torch.zeros(1, 4, 5), torch.tensor([step]))[0, 0].tolist()


def test_all_regions_are_guided_by_one_scale(sampling):
    assert scales_of(sampling(guidance=3.0)) == pytest.approx([3] * 5)
    assert scales_of(sampling(guidance=1.0)) == pytest.approx([1] * 5)
    assert scales_of(sampling(guidance=0.0)) == pytest.approx([0] * 5)


def test_a_region_may_have_a_scale_of_its_own(sampling):
    own = sampling(guidance=2.0, region_guidance={"mouth": 5.0, "head": 0.5})
    assert scales_of(own) == pytest.approx([2, 2, 5, 2, 0.5])


def test_guidance_is_on_in_its_interval_alone(sampling):
    own = sampling(guidance=2.0, region_guidance={"mouth": 5.0}, guidance_interval=(0.2, 0.6))
    for step in (0, 19, 61, 100):
        assert scales_of(own, step) == pytest.approx([1] * 5), step
    for step in (20, 50, 60):
        assert scales_of(own, step) == pytest.approx([2, 2, 5, 2, 2]), step


def test_regions_named_at_the_common_scale_change_nothing(made):
    named = {"region_guidance": dict.fromkeys(CONTROL_REGIONS, 2.0)}
    assert np.array_equal(made(asked(20))[0], made(asked(20), **named)[0])


def test_what_is_told_nothing_is_not_guided(made):
    free = [Request.both_sides(NULL)]
    weak, strong = (made(free, guidance=scale)[0] for scale in (1.0, 3.0))
    assert weak == pytest.approx(strong, abs=1e-5)


# Obedience


def test_the_model_does_what_it_is_asked_when_it_is_asked(obedient, sampling):
    (motion,) = sampled(obedient, [asking("BrowUp")], sampling(), WINDOW, [(0,)])
    up = motion[:, obedient.channels.index("browInnerUp")]
    assert up[13:28].min() > 0
    assert max(up[:8].max(), up[32:].max()) < -0.3


@pytest.mark.parametrize("action", ["BrowUp", "Smile", "EyeClose"])
@pytest.mark.parametrize("side", ["left", "right"])
def test_one_half_of_the_face_does_what_it_is_asked_alone(obedient, sampling, action, side):
    (motion,) = sampled(obedient, [asking(action, side=side)], sampling(), WINDOW, [(0,)])
    stem = {"BrowUp": "browOuterUp", "Smile": "mouthSmile", "EyeClose": "eyeBlink"}[action]
    level = {
        half: motion[13:28, obedient.channels.index(stem + half.capitalize())].mean()
        for half in ("left", "right")
    }
    other = {"left": "right", "right": "left"}[side]
    assert level[side] > 0.3
    assert level[other] < level[side] - 1


def test_a_channel_without_a_side_goes_part_of_the_way(obedient, sampling):
    inner = obedient.channels.index("browInnerUp")
    one, both, neither = (
        sampled(obedient, [request], sampling(), WINDOW, [(0,)])[0][13:28, inner].mean().item()
        for request in (
            asking("BrowUp", side="left"),
            asking("BrowUp"),
            Request.both_sides(np.zeros((40, 16))),
        )
    )
    assert neither + 0.5 < one < both - 0.5


def test_halves_that_are_asked_the_same_are_one_request(made):
    (values,) = timelines(40)
    plain, halves = Request.both_sides(values), Request(values, values.copy())
    assert np.array_equal(made([plain])[0], made([halves])[0])


def test_what_the_model_cannot_move_it_is_not_told(trained, sampling, caplog):
    """Its channels hold nothing of mouth, eyes or gaze but the jaw."""
    generator = torch.Generator().manual_seed(0)
    channels = ("browInnerUp", "head_yaw_left")
    deaf = TimelineModel(channels, 16, 2, 1, 1, "halves", "initial", "cosine", 100)
    deaf = deaf.initialise(generator).requires_grad_(False)
    for parameter in deaf.parameters():
        parameter.copy_(torch.randn(parameter.shape, generator=generator) * 0.3)
    smile, rest, head = asking("Smile"), Request.both_sides(np.zeros((40, 16))), asking("HeadUp")
    smiling, resting, turned = (
        sampled(deaf, [request], sampling(), WINDOW, [(0,)])[0] for request in (smile, rest, head)
    )
    assert torch.equal(smiling, resting)
    assert not torch.equal(turned, resting)
    with caplog.at_level(logging.WARNING):
        generate(trained, [asking("HeadUp"), asking("EyeClose", side="left")], sampling(), 0)
    assert caplog.messages == ["the model does not move what EyeClose would: left out"]


def test_one_request_too_long_for_memory_is_made_in_groups(made, monkeypatch):
    (whole,) = made(asked(200))
    monkeypatch.setattr(windows, "FRAMES", 3 * WINDOW)
    (grouped,) = made(asked(200))
    assert grouped == pytest.approx(whole, abs=1e-4)
