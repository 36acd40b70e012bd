import signal
import time

import pytest
import safetensors.torch
import torch

from mimeline.training.checkpoint import losses
from mimeline.training.processes import LostProcess, together

TASKS = """
import os, signal, time
import torch
from mimeline.errors import BadConfig

def one_refuses(word):
    if torch.distributed.get_rank() == 1:
        raise BadConfig("key", found=word, expected="another", remedy="Change it.")
    time.sleep(300)

def one_is_killed(word):
    if torch.distributed.get_rank() == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    torch.distributed.barrier()
"""


@pytest.fixture
def tasks(tmp_path, monkeypatch):
    """A module of tasks that new processes find, too."""
    (tmp_path / "tasks_of_a_test.py").write_text(TASKS)
    monkeypatch.syspath_prepend(tmp_path)
    import tasks_of_a_test

    return tasks_of_a_test


def test_two_processes_learn_what_one_learns(world, tmp_path, caplog):
    one = world.train(tmp_path / "one", steps=20)
    caplog.clear()
    with caplog.at_level("INFO"):
        two = world.train(tmp_path / "two", steps=20, hardware={"device": "cpu", "processes": 2})
    rows = [losses(folder) for folder in (one, two)]
    for column in ("loss", "val_loss", "gradient_norm"):
        assert rows[1][column].tolist() == pytest.approx(rows[0][column].tolist(), abs=1e-5)
    weights = [safetensors.torch.load_file(f / "model.safetensors") for f in (one, two)]
    assert all(torch.allclose(weights[0][n], weights[1][n], atol=1e-5) for n in weights[0])
    assert caplog.text.count("step 20 of 20") == 1


def test_an_error_in_one_process_is_the_error_of_all(tasks):
    began = time.monotonic()
    with pytest.raises(Exception, match="key: found too much, expected another") as error:
        together(2, "gloo", tasks.one_refuses, "too much")
    assert type(error.value).__name__ == "BadConfig"
    assert time.monotonic() - began < 120


def test_a_process_that_is_killed_ends_all_and_is_told(tasks):
    with pytest.raises(LostProcess, match=rf"process 2 of 2.*signal {signal.SIGKILL:d}"):
        together(2, "gloo", tasks.one_is_killed, "word")
