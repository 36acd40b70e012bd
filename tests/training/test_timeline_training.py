from dataclasses import replace

import pytest
import safetensors.torch
import torch

from mimeline import tables
from mimeline.dataset.statistics import statistics
from mimeline.dataset.windows import Batch
from mimeline.diffusion.schedule import SCHEDULES
from mimeline.models.timeline import TimelineModel
from mimeline.training import checkpoint as checkpoints
from mimeline.training.lesson import Lesson, square_error
from mimeline.training.timeline import noised
from mimeline.vocabulary import ACTIONS

from ..tiny import ARCHITECTURE

CHANNEL_NAMES = ("browInnerUp", "jawOpen", "head_yaw_left")


@pytest.fixture
def batch() -> Batch:
    """Two clips of six frames, of which the second lacks the head; two frames are not valid."""
    motion = torch.randn(2, 6, 3, generator=torch.Generator().manual_seed(0))
    valid = torch.ones(2, 6, dtype=torch.bool)
    valid[1, 4:] = False
    measured = valid[..., None].repeat(1, 1, 3)
    measured[1, :, 2] = False
    return Batch(("a", "b"), motion * measured, torch.zeros(2, 6, 16), valid, measured)


def told(batch: Batch) -> Lesson:
    generator = torch.Generator().manual_seed(1)
    return noised(batch, batch.timeline, SCHEDULES["cosine"](100), generator)


def loss_of(batch: Batch, wrong: torch.Tensor) -> float:
    """Of a model that gives the batch's motion, off by `wrong` (B, L, D)."""
    return square_error(lambda *_: batch.motion + wrong, told(batch)).item()


def test_what_was_not_measured_does_not_count_in_the_loss(batch):
    assert loss_of(batch, 100.0 * ~batch.measured) == 0.0


def test_the_loss_is_the_mean_over_what_was_measured(batch):
    wrong = torch.randn(2, 6, 3, generator=torch.Generator().manual_seed(2))
    expected = wrong[batch.measured].square().mean().item()
    assert loss_of(batch, wrong) == pytest.approx(expected)
    whole = replace(batch, measured=batch.valid[..., None].expand(2, 6, 3))
    assert loss_of(whole, wrong) == pytest.approx(wrong[batch.valid].square().mean().item())


def test_the_losses_of_the_parts_of_a_lesson_add_up_to_its_own(batch):
    model = TimelineModel(CHANNEL_NAMES, **ARCHITECTURE).initialise(
        torch.Generator().manual_seed(3)
    )
    lesson, cpu = told(batch), torch.device("cpu")
    parts = [lesson.part(number, 2, cpu) for number in range(2)]
    assert [part.clip_ids for part in parts] == [("a",), ("b",)]
    whole = square_error(model, lesson).item()
    assert sum(square_error(model, part).item() for part in parts) == pytest.approx(whole)


def test_clips_without_a_head_still_train(world, tmp_path, caplog):
    motion = tables.read(tables.MOTION, world.motion)
    head = motion["head_yaw_left"].where(motion["clip_id"] == "one")
    motion = motion.assign(head_yaw_left=head)
    files = {name: tmp_path / f"{name}.parquet" for name in ("motion", "statistics")}
    headless = replace(world, **files)
    tables.write(tables.MOTION, motion, headless.motion)
    trained_on = statistics(motion[motion["clip_id"] != "val"])
    tables.write(tables.STATISTICS, trained_on, headless.statistics)
    with caplog.at_level("INFO"):
        checkpoint = headless.train(tmp_path / "timeline")
    assert "3 clips, 114 valid frames to train on" in caplog.text
    assert "2 of them lack a channel" in caplog.text
    assert set(checkpoints.load(checkpoint).normaliser.channels) == set(CHANNEL_NAMES)
    checked = checkpoints.losses(checkpoint)["val_loss"]  # of a clip without a head
    assert checked.iloc[-1] < 0.9 * checked.iloc[0]


@pytest.fixture
def unasked(world, tmp_path):
    """The world, but nobody asks for an action."""
    found = replace(world, frames=tmp_path / "frames.parquet")
    frames = tables.read(tables.FRAMES, world.frames)
    tables.write(tables.FRAMES, frames.assign(**dict.fromkeys(ACTIONS, False)), found.frames)
    return found


@pytest.mark.parametrize(
    ("drop_all", "drop_none", "matters"), [(1.0, 0.0, False), (0.0, 1.0, True)]
)
def test_a_timeline_that_is_dropped_teaches_nothing(
    drop_all, drop_none, matters, world, unasked, tmp_path
):
    weights = []
    for name, asked in (("world", world), ("unasked", unasked)):
        changes = {"drop_all": drop_all, "drop_none": drop_none, "steps": 3}
        folder = asked.train(tmp_path / name, **changes)
        weights.append(safetensors.torch.load_file(folder / "model.safetensors"))
    differ = [name for name in weights[0] if not torch.equal(weights[0][name], weights[1][name])]
    assert bool(differ) == matters


def test_a_trained_model_knows_the_jitter_of_its_channels(trained):
    found = checkpoints.load(trained)
    jitter = found.model.jitter
    sizes = (jitter.basis @ jitter.variance.diag() @ jitter.basis.T).diag().sqrt()
    planted = torch.from_numpy(0.02 / found.normaliser.std)  # of a world whose noise is 0.02
    assert sizes.tolist() == pytest.approx(planted.tolist(), rel=0.2)
