import itertools

import pytest
import torch

from mimeline.dataset.windows import Batch
from mimeline.training.average import Average
from mimeline.training.loop import TrainingDiverged, fit, learning_rate

BATCH = Batch(
    ("beta", "alpha"),
    motion=torch.ones(2, 4, 1),
    timeline=torch.ones(2, 4, 16),
    valid=torch.ones(2, 4).bool(),
    measured=torch.ones(2, 4, 1).bool(),
)
SETTINGS = {"steps": 40, "peak": 0.05, "clip_norm": 1.0, "ema": 0.9}


def line() -> torch.nn.Linear:
    model = torch.nn.Linear(1, 1)
    torch.nn.init.zeros_(model.weight)
    torch.nn.init.zeros_(model.bias)
    return model


def square(model, batch):
    return (model(batch.motion) - 3 * batch.motion).square().mean()


def test_the_loss_falls_and_the_average_follows():
    run = fit(line(), itertools.repeat(BATCH), square, lambda model: 7.0, **SETTINGS)
    assert run.losses["loss"].iloc[-1] < 0.1 * run.losses["loss"].iloc[0]
    assert run.losses["step"].iloc[-1] == SETTINGS["steps"]
    assert (run.losses["val_loss"] == 7.0).all()
    assert square(run.average, BATCH) < square(line(), BATCH)
    assert not torch.equal(run.average.weight, run.model.weight)
    assert not run.model.training


def test_a_loss_that_is_not_finite_ends_the_training_and_names_the_clips():
    losses = itertools.chain([1.0, 1.0], itertools.repeat(float("nan")))

    def loss(model, batch):
        return model(batch.motion).mean() + next(losses)

    with pytest.raises(
        TrainingDiverged, match=r"alpha, beta, training step 3: found a loss of nan"
    ):
        fit(line(), itertools.repeat(BATCH), loss, lambda model: None, **SETTINGS)


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
