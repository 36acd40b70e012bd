import itertools

import pytest
import torch

from mimeline.models.timeline import TimelineModel, seen_actions
from mimeline.vocabulary import ACTIONS, CHANNELS, OUTPUT_GROUPS, region_actions

CHANNEL_NAMES = ["browInnerUp", "mouthSmileLeft", "head_yaw_left", "eyeBlinkLeft", "jawOpen"]
ORDER = list(ACTIONS)


def lively(**changes) -> TimelineModel:
    """A small model whose every weight does something."""
    shape = {
        "width": 16,
        "heads": 2,
        "base_layers": 2,
        "branch_layers": 1,
        "diffusion_steps": 1000,
    } | changes
    model = TimelineModel(CHANNEL_NAMES, **shape).eval()
    generator = torch.Generator().manual_seed(0)
    with torch.no_grad():
        for parameter in model.parameters():
            parameter.copy_(torch.randn(parameter.shape, generator=generator) * 0.3)
    return model


def inputs(batch: int = 2, length: int = 12):
    generator = torch.Generator().manual_seed(1)
    noisy = torch.randn(batch, length, len(CHANNEL_NAMES), generator=generator)
    timeline = torch.randint(-1, 2, (batch, length, len(ACTIONS)), generator=generator).float()
    step = torch.randint(0, 1000, (batch,), generator=generator)
    return noisy, step, timeline, torch.ones(batch, length, dtype=torch.bool)


def with_action(timeline, action, frames=slice(None)):
    changed = timeline.clone()
    changed[:, frames, ORDER.index(action)] = 1 - changed[:, frames, ORDER.index(action)].clamp(0)
    return changed


@torch.no_grad()
def test_padding_does_not_change_the_valid_frames():
    model, (noisy, step, timeline, valid) = lively(), inputs(length=12)
    short = model(noisy[:, :7], step, timeline[:, :7], valid[:, :7])
    valid[:, 7:] = False
    assert torch.allclose(model(noisy, step, timeline, valid)[:, :7], short, atol=1e-5)


@torch.no_grad()
def test_frames_that_are_not_valid_say_nothing_even_in_the_middle():
    model, (noisy, step, timeline, valid) = lively(), inputs()
    valid[:, 4:6] = False
    before = model(noisy, step, timeline, valid)
    noisy[:, 4:6] += 5
    timeline[:, 4:6] = 0
    after = model(noisy, step, timeline, valid)
    assert torch.allclose(before[valid], after[valid], atol=1e-5)
    assert torch.isfinite(after).all()


@torch.no_grad()
def test_without_the_base_a_branch_follows_only_its_own_timelines():
    model, (noisy, step, timeline, valid) = lively(), inputs()
    model.base.embed_timeline.weight.zero_()
    before = model(noisy, step, timeline, valid)
    changed = {
        action: (model(noisy, step, with_action(timeline, action), valid) - before)
        .abs()
        .amax((0, 1))
        for action in ("BrowUp", "Smile", "HeadLeft")
    }
    moved = {
        action: {c for i, c in enumerate(CHANNEL_NAMES) if by_channel[i] > 1e-4}
        for action, by_channel in changed.items()
    }
    assert moved["BrowUp"] == {"browInnerUp", "eyeBlinkLeft", "head_yaw_left"}
    assert moved["Smile"] == {"mouthSmileLeft", "jawOpen", "head_yaw_left"}
    assert moved["HeadLeft"] == {"head_yaw_left"}


@torch.no_grad()
def test_with_the_base_every_timeline_reaches_every_channel():
    model, (noisy, step, timeline, valid) = lively(), inputs()
    before = model(noisy, step, timeline, valid)
    after = model(noisy, step, with_action(timeline, "BrowUp"), valid)
    assert ((after - before).abs().amax((0, 1)) > 1e-4).all()


def test_branches_see_the_regions_of_the_paper():
    def names(group):
        return [ORDER[i] for i in seen_actions(group)]

    assert names("lower") == list(region_actions("mouth"))
    assert names("rest") == ORDER
    assert names("upper") == [
        n for n in ORDER if ACTIONS[n].control_region in ("brow", "eye", "gaze")
    ]


@torch.no_grad()
def test_each_layer_reads_the_initial_timeline():
    model, (noisy, step, timeline, valid) = lively(), inputs()
    given = []
    for layer in model.base.layers:
        layer.register_forward_pre_hook(lambda _, args: given.append(args[1]))
    model(noisy, step, timeline, valid)
    assert len(given) == 2
    assert torch.equal(given[0], given[1])

    # Deaf in its first layer, the base still hears the timeline in its second.
    model.base.layers[0].attended.weight.zero_()
    for branch in model.branches.values():
        branch.embed_timeline.weight.zero_()
    before = model(noisy, step, timeline, valid)
    after = model(noisy, step, with_action(timeline, "BrowUp"), valid)
    assert (after - before).abs().max() > 1e-4


@torch.no_grad()
def test_an_untrained_frame_listens_to_its_own_timeline_most():
    shape = {"width": 32, "heads": 2, "base_layers": 1, "branch_layers": 1, "diffusion_steps": 1000}
    generator = torch.Generator().manual_seed(0)
    model = TimelineModel(CHANNEL_NAMES, **shape).initialise(generator).eval()
    for output in model.outputs.values():
        torch.nn.init.normal_(output.weight, generator=generator)
    noisy, step, timeline, valid = inputs(batch=64, length=40)
    before = model(noisy, step, timeline, valid)
    after = model(noisy, step, with_action(timeline, "BrowUp", slice(20, 21)), valid)
    assert (after - before).abs().mean(dim=(0, 2)).argmax().item() == 20


@torch.no_grad()
def test_dropped_absent_and_asked_for_are_three_things():
    model, (noisy, step, timeline, valid) = lively(), inputs()
    out = [model(noisy, step, torch.full_like(timeline, v), valid) for v in (-1.0, 0.0, 1.0)]
    assert min((a - b).abs().max() for a, b in itertools.combinations(out, 2)) > 1e-3


@torch.no_grad()
def test_the_diffusion_step_reaches_every_layer():
    model, (noisy, step, timeline, valid) = lively(), inputs()
    seen = []
    for network in (model.base, *model.branches.values()):
        for layer in network.layers:
            layer.register_forward_hook(lambda _, args, out: seen.append((args[2], out)))
    model(noisy, step, timeline, valid)
    model(noisy, (step + 300) % 1000, timeline, valid)
    first, second = seen[: len(seen) // 2], seen[len(seen) // 2 :]
    assert len(first) == 2 + len(model.branches)
    assert all((a[0] - b[0]).abs().max() > 1e-3 for a, b in zip(first, second, strict=True))


@torch.no_grad()
def test_the_first_guess_makes_nothing_up():
    shape = {"width": 16, "heads": 2, "base_layers": 1, "branch_layers": 1, "diffusion_steps": 1000}
    model = TimelineModel(list(CHANNELS), **shape).initialise(torch.Generator().manual_seed(0))
    noisy = torch.randn(2, 5, len(CHANNELS), generator=torch.Generator().manual_seed(1))
    timeline, valid = torch.zeros(2, 5, 16), torch.ones(2, 5, dtype=torch.bool)
    step = torch.tensor([3, 900])
    signal, _ = model.schedule.at(step, noisy)
    assert torch.allclose(model(noisy, step, timeline, valid), 0.5 * signal * noisy)


@torch.no_grad()
def test_a_channel_that_keeps_its_noisy_value_is_hardly_changed_where_noise_is_least():
    model, (noisy, step, timeline, valid) = lively(), inputs()
    model.keep.weight.zero_()
    model.keep.bias.copy_(torch.tensor([30.0, -30, 30, 30, 30]))
    off = (model(noisy, torch.zeros_like(step), timeline, valid) - noisy).abs().amax((0, 1))  # (D,)
    assert off[1] > 0.5
    assert off[[0, 2, 3, 4]].max() < 0.1


def test_a_seed_settles_every_weight():
    shape = {"width": 16, "heads": 2, "base_layers": 1, "branch_layers": 1, "diffusion_steps": 1000}
    one, two, other = (
        TimelineModel(CHANNEL_NAMES, **shape).initialise(torch.Generator().manual_seed(seed))
        for seed in (4, 4, 5)
    )
    first, again, third = (dict(model.named_parameters()) for model in (one, two, other))
    assert all(torch.equal(first[name], again[name]) for name in first)
    assert any(not torch.equal(first[name], third[name]) for name in first)


@torch.no_grad()
@pytest.mark.parametrize("absent", OUTPUT_GROUPS)
def test_a_source_without_a_group_of_channels_has_no_branch_for_it(absent):
    names = [c.name for c in CHANNELS.values() if c.output_group != absent]
    model = TimelineModel(
        names, width=16, heads=2, base_layers=1, branch_layers=1, diffusion_steps=10
    )
    assert set(model.branches) == set(OUTPUT_GROUPS) - {absent}
    noisy = torch.zeros(1, 4, len(names))
    valid = torch.ones(1, 4, dtype=torch.bool)
    assert model(noisy, torch.tensor([5]), torch.zeros(1, 4, 16), valid).shape == noisy.shape
