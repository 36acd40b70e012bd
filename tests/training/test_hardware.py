import numpy as np
import pytest
import torch

from mimeline.config.sections import Config
from mimeline.errors import BadConfig
from mimeline.training.checkpoint import losses
from mimeline.training.hardware import Hardware


def test_half_precision_learns_nearly_the_same(world, tmp_path):
    hardware = {"device": "cpu", "precision": "bfloat16"}
    half = losses(world.train(tmp_path / "half", hardware=hardware, steps=10))["loss"]
    precise = losses(world.train(tmp_path / "precise", steps=10))["loss"]
    assert np.isfinite(half).all()
    assert half.tolist() == pytest.approx(precise.tolist(), rel=0.02)
    assert half.tolist() != precise.tolist()


def test_float16_needs_a_gpu():
    with pytest.raises(BadConfig, match=r"train.hardware.precision: found float16"):
        Hardware(device="cpu", precision="float16")


@pytest.mark.parametrize("gpus", [0, 1])
def test_a_gpu_that_is_not_there_is_told(gpus, monkeypatch):
    monkeypatch.setattr(torch.cuda, "device_count", lambda: gpus)
    monkeypatch.setattr(torch.cuda, "is_available", lambda: gpus > 0)
    with pytest.raises(BadConfig, match=r"train.hardware.(device|processes)"):
        Hardware(device="cuda", processes=2)


def test_every_process_needs_a_clip_of_each_batch():
    train = {"hardware": {"processes": 9}, "timeline": {"batch": 8}}
    with pytest.raises(ValueError, match="train.hardware.processes to be at most"):
        Config(train=train)
