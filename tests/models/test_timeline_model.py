import itertools

import pytest
import torch

from mimeline.models.divisions import parts
from mimeline.models.timeline import Network, TimelineModel
from mimeline.vocabulary import ACTIONS, CHANNELS, CONTROL_REGIONS, OUTPUT_GROUPS, region_actions

CHANNEL_NAMES = ["browInnerUp", "mouthSmileLeft", "head_yaw_left", "eyeBlinkLeft", "jawOpen"]
ORDER = list(ACTIONS)
SHAPE = {
    "width": 16,
    "heads": 2,
    "base_layers": 2,
    "branch_layers": 1,
    "branches": "halves",
    "timeline_tokens": "initial",
    "schedule": "cosine",
    "diffusion_steps": 1000,
}


def lively(channels=CHANNEL_NAMES, **changes) -> TimelineModel:
    """A small model whose every weight does something."""
    model = TimelineModel(channels, **SHAPE | changes).eval()
    generator = torch.Generator().manual_seed(0)
    with torch.no_grad():
        for parameter in model.parameters():
            parameter.copy_(torch.randn(parameter.shape, generator=generator) * 0.3)
    return model


def inputs(batch: int = 2, length: int = 12, channels: int = len(CHANNEL_NAMES)):
    generator = torch.Generator().manual_seed(1)
    noisy = torch.randn(batch, length, channels, generator=generator)
    timeline = torch.randint(-1, 2, (batch, length, len(ACTIONS)), generator=generator).float()
    step = torch.randint(0, 1000, (batch,), generator=generator)
    return noisy, step, timeline, torch.ones(batch, length, dtype=torch.bool)


def with_action(timeline, action, frames=slice(None)):
    changed = timeline.clone()
    changed[:, frames, ORDER.index(action)] = 1 - changed[:, frames, ORDER.index(action)].clamp(0)
    return changed


def followers(model, action, channels=CHANNEL_NAMES) -> set[str]:
    """The channels that change with the timeline of an action."""
    noisy, step, timeline, valid = inputs(channels=len(channels))
    before = model(noisy, step, timeline, valid)
    change = model(noisy, step, with_action(timeline, action), valid) - before
    return {c for c, own in zip(channels, change.abs().amax((0, 1)), strict=True) if own > 1e-4}


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
def test_without_a_base_a_branch_follows_its_own_timelines_alone():
    model = lively(base_layers=0)
    assert model.base is None
    assert followers(model, "BrowUp") == {"browInnerUp", "eyeBlinkLeft", "head_yaw_left"}
    assert followers(model, "Smile") == {"mouthSmileLeft", "jawOpen", "head_yaw_left"}
    assert followers(model, "HeadLeft") == {"head_yaw_left"}


@torch.no_grad()
@pytest.mark.parametrize("channel", range(len(CHANNEL_NAMES)))
def test_without_a_base_a_branch_sees_its_own_noisy_channels_alone(channel):
    model, (noisy, step, timeline, valid) = lively(base_layers=0), inputs()
    before = model(noisy, step, timeline, valid)
    noisy[..., channel] += 2
    change = (model(noisy, step, timeline, valid) - before).abs().amax((0, 1))
    own = next(part.columns for part in model.parts.values() if channel in part.columns)
    assert change.nonzero()[:, 0].tolist() == own


@torch.no_grad()
def test_with_a_base_every_timeline_and_noisy_channel_reaches_every_channel():
    model, (noisy, step, timeline, valid) = lively(), inputs()
    assert followers(model, "BrowUp") == set(CHANNEL_NAMES)
    before = model(noisy, step, timeline, valid)
    noisy[..., 1] += 2
    assert ((model(noisy, step, timeline, valid) - before).abs().amax((0, 1)) > 1e-4).all()


@torch.no_grad()
def test_without_branches_the_base_makes_the_whole_face():
    model = lively(branch_layers=0)
    assert not model.branches
    assert list(model.outputs) == ["face"]
    assert followers(model, "HeadLeft") == set(CHANNEL_NAMES)


@torch.no_grad()
def test_all_decoupled_each_region_follows_its_own_timeline():
    names = [*CHANNEL_NAMES, "gaze_left", "cheekPuff"]
    model = lively(names, base_layers=0, branches="regions")
    assert followers(model, "BrowUp", names) == {"browInnerUp", "cheekPuff"}
    assert followers(model, "EyeClose", names) == {"eyeBlinkLeft", "cheekPuff"}
    assert followers(model, "GazeLeft", names) == {"gaze_left", "cheekPuff"}
    assert followers(model, "HeadLeft", names) == {"head_yaw_left", "cheekPuff"}
    assert followers(model, "Smile", names) == {"mouthSmileLeft", "jawOpen", "cheekPuff"}


@pytest.mark.parametrize("division", ["halves", "regions"])
def test_every_channel_has_one_part(division):
    columns = [c for part in parts(list(CHANNELS), division).values() for c in part.columns]
    assert sorted(columns) == list(range(len(CHANNELS)))


def test_parts_see_the_regions_of_the_paper():
    def names(part):
        return [ORDER[i] for i in part.actions]

    halves = parts(list(CHANNELS), "halves")
    assert names(halves["lower"]) == list(region_actions("mouth"))
    assert names(halves["rest"]) == ORDER
    upper = [n for n in ORDER if ACTIONS[n].control_region in ("brow", "eye", "gaze")]
    assert names(halves["upper"]) == upper
    regions = parts(list(CHANNELS), "regions")
    assert all(names(regions[r]) == list(region_actions(r)) for r in CONTROL_REGIONS)
    assert names(regions["rest"]) == ORDER


@torch.no_grad()
@pytest.mark.parametrize(("tokens", "same"), [("initial", True), ("carried", False)])
def test_a_layer_reads_the_initial_timeline_or_that_of_the_layer_before(tokens, same, monkeypatch):
    model, read = lively(timeline_tokens=tokens, branch_layers=0), []
    for layer in model.base.layers:
        monkeypatch.setattr(
            layer, "hear", lambda c, t, hear=layer.hear: read.append(c) or hear(c, t)
        )
    model(*inputs())
    assert len(read) == 2
    assert torch.equal(*read) == same


@torch.no_grad()
def test_carried_timelines_give_other_motion_from_the_second_layer_on():
    one, two = (
        [lively(timeline_tokens=t, branch_layers=0, base_layers=n) for t in ("initial", "carried")]
        for n in (1, 2)
    )
    given = inputs()
    assert torch.equal(one[0](*given), one[1](*given))
    assert (two[0](*given) - two[1](*given)).abs().max() > 1e-3


def test_depth_is_split_between_base_and_branches():
    def depth(base, branch):
        model = TimelineModel(
            CHANNEL_NAMES, **SHAPE | {"base_layers": base, "branch_layers": branch}
        )
        base = len(model.base.layers) if model.base else 0
        return base, {len(own.layers) for own in model.branches.values()}

    assert depth(3, 1) == (3, {1})
    assert depth(1, 3) == (1, {3})
    assert depth(4, 0) == (4, set())
    assert depth(0, 4) == (0, {4})


def test_a_model_of_neither_base_nor_branch_is_refused():
    with pytest.raises(ValueError, match="base or branches"):
        TimelineModel(CHANNEL_NAMES, **SHAPE | {"base_layers": 0, "branch_layers": 0})


@torch.no_grad()
def test_the_noise_schedule_is_the_models_own():
    cosine, linear = lively(), lively(schedule="linear")
    assert len(lively(diffusion_steps=20).schedule) == 20
    assert (cosine(*inputs()) - linear(*inputs())).abs().max() > 1e-3


@torch.no_grad()
@pytest.mark.parametrize("tokens", ["initial", "carried"])
def test_a_timeline_is_listened_to_once_for_all_steps(tokens):
    model, (noisy, _, timeline, valid) = lively(timeline_tokens=tokens), inputs()
    embedded = []
    for network in (m for m in model.modules() if isinstance(m, Network)):
        network.embed_timeline.register_forward_hook(lambda *_: embedded.append(1))
    denoise = model.listen(timeline, valid)
    told = len(embedded)
    made = {step: denoise(noisy, torch.tensor([step, step])) for step in (0, 300, 999)}
    assert len(embedded) == told == 1 + len(model.branches)
    for step, own in made.items():
        assert torch.equal(own, model(noisy, torch.tensor([step, step]), timeline, valid))


@torch.no_grad()
def test_what_initial_timelines_say_is_worked_out_before_the_first_step(monkeypatch):
    model, (noisy, step, timeline, valid) = lively(), inputs()
    heard = []
    layers = [*model.base.layers, *(x for b in model.branches.values() for x in b.layers)]
    for layer in layers:
        monkeypatch.setattr(layer, "hear", lambda *a, hear=layer.hear: heard.append(1) or hear(*a))
    denoise = model.listen(timeline, valid)
    for _ in range(3):
        denoise(noisy, step)
    assert len(heard) == len(layers)


@torch.no_grad()
def test_in_bfloat16_motion_stays_float32_and_near():
    model, given = lively(), inputs()
    whole = model(*given)
    half = model.to(torch.bfloat16)(*given)
    assert half.dtype == torch.float32
    assert torch.isfinite(half).all()
    assert 0 < (half - whole).abs().max() < 0.1 * whole.abs().max()


def test_the_size_of_the_paper_can_be_built():
    with torch.device("meta"):
        embed = Network(len(ACTIONS), 512, 8, 8, carried=False)
    assert len(embed.layers) == 8
    assert sum(p.numel() for p in embed.parameters()) > 10_000_000


@torch.no_grad()
def test_an_untrained_frame_listens_to_its_own_timeline_most():
    generator = torch.Generator().manual_seed(0)
    model = TimelineModel(CHANNEL_NAMES, **SHAPE | {"width": 32, "base_layers": 1})
    model.initialise(generator).eval()
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
def test_the_first_guess_makes_nothing_up():
    model = TimelineModel(list(CHANNELS), **SHAPE).initialise(torch.Generator().manual_seed(0))
    noisy, _, timeline, valid = inputs(channels=len(CHANNELS))
    step = torch.tensor([3, 900])
    signal, _ = model.schedule.at(step, noisy)
    assert torch.allclose(model(noisy, step, timeline, valid), 0.5 * signal * noisy)


def test_a_seed_settles_every_weight():
    first, again, third = (
        dict(
            TimelineModel(CHANNEL_NAMES, **SHAPE)
            .initialise(torch.Generator().manual_seed(seed))
            .named_parameters()
        )
        for seed in (4, 4, 5)
    )
    assert all(torch.equal(first[name], again[name]) for name in first)
    assert any(not torch.equal(first[name], third[name]) for name in first)


@torch.no_grad()
@pytest.mark.parametrize("absent", OUTPUT_GROUPS)
def test_a_source_without_a_group_of_channels_has_no_branch_for_it(absent):
    names = [c.name for c in CHANNELS.values() if c.output_group != absent]
    model = lively(names)
    assert set(model.branches) == set(OUTPUT_GROUPS) - {absent}
    noisy, step, timeline, valid = inputs(channels=len(names))
    assert model(noisy, step, timeline, valid).shape == noisy.shape
