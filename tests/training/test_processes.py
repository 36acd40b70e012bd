import fcntl
import os
import signal
import tempfile
import time

import pytest
import safetensors.torch
import torch

from mimeline.training.checkpoint import losses
from mimeline.training.processes import LostProcess, together

TASKS = """
import fcntl, os, signal, time
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

def all_lock_a_file(folder):
    with open(f"{folder}/{torch.distributed.get_rank()}", "w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        time.sleep(120)
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


def locked(folder) -> int:
    """How many files a living process has locked."""
    count = 0
    for path in folder.iterdir():
        with path.open() as file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                count += 1
    return count


def until(happens, limit_s: float) -> bool:
    """Wait until it happens; whether it did in time."""
    end = time.monotonic() + limit_s
    while not (done := happens()) and time.monotonic() < end:
        time.sleep(0.02)
    return done


def test_the_processes_end_with_a_parent_that_is_killed(tasks, tmp_path, monkeypatch):
    folder = tmp_path / "locks"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))  # for what a killed one leaves
    parent = os.fork()
    if not parent:
        try:
            together(2, "gloo", tasks.all_lock_a_file, str(folder))
        finally:
            os._exit(1)
    try:
        assert until(lambda: locked(folder) == 2, 300)
    finally:
        os.kill(parent, signal.SIGKILL)
        os.waitpid(parent, 0)
    assert until(lambda: locked(folder) == 0, 60)
