import itertools
import math
from dataclasses import replace

import pytest
import torch

from mimeline.training.average import Average
from mimeline.training.hardware import Hardware
from mimeline.training.lesson import Lesson, square_error
from mimeline.training.loop import TrainingDiverged, fit, learning_rate

ONES = torch.ones(2, 4, 1)
CPU = Hardware("cpu")
TRIPLE = Lesson(("beta", "alpha"), (ONES,), target=3 * ONES, weight=ONES / 8)


def line() -> torch.nn.Linear:
    model = torch.nn.Linear(1, 1)
    torch.nn.init.zeros_(model.weight)
    torch.nn.init.zeros_(model.bias)
    return model


def learn(lessons=None, loss=square_error, held=TRIPLE, hardware=CPU):
    return fit(
        line(),
        lessons or itertools.repeat(TRIPLE),
        loss,
        held,
        torch.Generator(),
        steps=40,
        peak=0.05,
        clip_norm=1.0,
        ema=0.9,
        save_every=500,
        hardware=hardware,
        state=None,
        tensorboard=None,
    )


def test_the_loss_falls_and_the_average_follows():
    run = learn()
    assert run.losses["loss"].iloc[-1] < 0.1 * run.losses["loss"].iloc[0]
    assert run.losses["step"].tolist() == list(range(1, 41))
    with torch.no_grad():
        assert run.losses["val_loss"].iloc[-1] == square_error(run.average, TRIPLE).item()
    assert square_error(run.average, TRIPLE) < square_error(line(), TRIPLE)
    assert not torch.equal(run.average.weight, run.model.weight)
    assert not run.model.training


def test_the_gradient_norm_is_told_as_it_was_before_clipping():
    first = learn().losses["gradient_norm"].iloc[0]
    assert first == pytest.approx(math.hypot(6, 6))  # of (w + b - 3)^2 at zero


def test_a_wild_lesson_spoils_no_more_than_another():
    wild = replace(TRIPLE, target=-1e6 * ONES)
    run = learn(itertools.chain([TRIPLE, wild], itertools.repeat(TRIPLE)))
    assert run.losses["loss"].iloc[-1] < 0.5 * run.losses["loss"].iloc[0]


def test_without_a_held_lesson_there_is_no_validation_loss():
    assert learn(held=None).losses["val_loss"].isna().all()


def test_a_loss_that_is_not_finite_ends_the_training_and_names_the_clips():
    off = itertools.chain([0.0, 0.0], itertools.repeat(float("nan")))
    lessons = (replace(TRIPLE, target=TRIPLE.target + number) for number in off)
    with pytest.raises(
        TrainingDiverged, match=r"alpha, beta, training step 3: found a loss of nan"
    ):
        learn(lessons)


def test_a_gradient_that_is_not_finite_ends_the_training_and_names_the_clips():
    def loss(model, lesson):
        return model(lesson.shown[0]).sum().abs().sqrt()  # of slope inf at zero

    with pytest.raises(TrainingDiverged, match=r"alpha, beta, training step 1: found a gradient"):
        learn(loss=loss)


class Scaled(Hardware):
    """A CPU on which gradients are scaled, from `scale` on, as for float16 on a GPU."""

    scale = 4.0

    def accelerator(self):
        found = super().accelerator()
        found.scaler = torch.amp.GradScaler("cpu", init_scale=self.scale)
        return found


def steep(times):
    """A loss whose slope is infinite for so many steps."""
    left = iter(range(times))

    def loss(model, lesson):
        extra = (0 * model(lesson.shown[0]).sum()).sqrt() if next(left, None) is not None else 0
        return square_error(model, lesson) + extra

    return loss


def test_a_step_whose_gradient_is_too_large_for_float16_is_skipped():
    rows = learn(loss=steep(2), held=None, hardware=Scaled("cpu")).losses
    assert rows["gradient_norm"].isna().tolist() == [True] * 2 + [False] * 38
    assert rows["loss"].iloc[0] == rows["loss"].iloc[1] == rows["loss"].iloc[2]
    assert rows["loss"].iloc[-1] < 0.1 * rows["loss"].iloc[0]


def test_a_gradient_that_no_scale_makes_finite_ends_a_training_in_float16():
    with pytest.raises(TrainingDiverged, match="training step 4: found a gradient"):  # 4, 2, 1, 1/2
        learn(loss=steep(40), held=None, hardware=Scaled("cpu"))


def test_every_step_is_as_long_as_the_learning_rate_says():
    weights = []

    def loss(model, lesson):  # of a slope that stays, so that Adam's steps are the rate itself
        weights.append(model.bias.item())
        return -model(lesson.shown[0]).mean()

    rows = learn(loss=loss, held=None).losses
    rates = [learning_rate(step, 40, 0.05) for step in range(40)]
    assert rows["learning_rate"].tolist() == rates
    lengths = [after - before for before, after in itertools.pairwise(weights)]
    assert lengths == pytest.approx(rates[:-1], rel=0.05)


def test_the_learning_rate_rises_to_its_peak_and_falls_to_a_tenth():
    rates = [learning_rate(step, 200, 1.0) for step in range(200)]
    assert rates[0] == pytest.approx(0.1)
    assert max(rates) == pytest.approx(1.0)
    assert rates.index(max(rates)) in (9, 10)
    assert rates[-1] == pytest.approx(0.1, abs=1e-3)
    assert all(a >= b for a, b in itertools.pairwise(rates[10:]))


def test_an_average_forgets_the_start_and_settles_on_a_steady_model():
    model = line()
    average = Average(model, decay=0.99)
    torch.nn.init.ones_(model.weight)
    average.update(model)
    assert average.model.weight.item() == pytest.approx(1 - 2 / 11)
    for _ in range(1000):
        average.update(model)
    assert average.model.weight.item() == pytest.approx(1.0, abs=1e-3)
