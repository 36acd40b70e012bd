"""An interrupted training goes on as if nothing had been."""

import errno
import os
import signal
from pathlib import Path

import pytest
import safetensors.torch
import torch

from mimeline.room import NoRoom
from mimeline.training.average import Average
from mimeline.training.checkpoint import losses
from mimeline.training.journal import Journal
from mimeline.training.state import State, finished

STEPS, SAVED = 6, 2
BRIEF = {"steps": STEPS, "save_every": SAVED}


@pytest.fixture(scope="module", autouse=True)
def rows_between_saves():
    """Rows of losses at steps 3 and 6: a save falls amid the steps of one."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("mimeline.training.journal.ROWS", 2)
        yield


@pytest.fixture(scope="module")
def whole_run(world, tmp_path_factory) -> Path:
    """The checkpoint of a short training that nothing interrupted."""
    return world.train(tmp_path_factory.mktemp("whole") / "timeline", **BRIEF)


def same(one: Path, other: Path) -> bool:
    """Whether weights and losses are the same to the last bit."""
    tables = [losses(folder).drop(columns="seconds") for folder in (one, other)]
    weights = [safetensors.torch.load_file(folder / "model.safetensors") for folder in (one, other)]
    return tables[0].equals(tables[1]) and all(
        torch.equal(weights[0][name], weights[1][name]) for name in weights[0] | weights[1]
    )


class Stopped(Exception):
    """What interrupts a training."""


@pytest.fixture
def stopped_at(monkeypatch, world, tmp_path):
    """Trains until the save of that step stands; gives the folder of all states."""

    def run(step: int, **changes) -> Path:
        save = State.save

        def save_and_stop(self, at):
            save(self, at)
            if at == step:
                raise Stopped

        with monkeypatch.context() as patch:
            patch.setattr(State, "save", save_and_stop)
            with pytest.raises(Stopped):
                world.train(tmp_path / "a", state=tmp_path / "state", **BRIEF | changes)
        return tmp_path / "state"

    return run


def test_a_stopped_training_ends_with_the_same_losses_and_weights(
    world, tmp_path, whole_run, stopped_at, caplog
):
    state = stopped_at(4)
    with caplog.at_level("INFO"):
        checkpoint = world.train(tmp_path / "a", state=state, **BRIEF)
    assert "resumed at step 4 of 6" in caplog.text
    assert same(checkpoint, whole_run)


def test_a_training_killed_amid_a_save_ends_with_the_same_losses_and_weights(
    world, tmp_path, whole_run, caplog
):
    child = os.fork()
    if not child:  # dies by its own hand, with half of the second save's weights on the disk
        write = Path.write_bytes

        def write_half(path, content):
            if f"{2 * SAVED:09d}" in path.name:
                write(path, content[: len(content) // 2])
                os.kill(os.getpid(), signal.SIGKILL)
            return write(path, content)

        Path.write_bytes = write_half
        try:
            world.train(tmp_path / "a", state=tmp_path / "state", **BRIEF)
        finally:
            os._exit(1)
    assert os.WTERMSIG(os.waitpid(child, 0)[1]) == signal.SIGKILL
    assert list(tmp_path.rglob("*.tmp"))
    with caplog.at_level("INFO"):
        checkpoint = world.train(tmp_path / "a", state=tmp_path / "state", **BRIEF)
    assert "resumed at step 2 of 6" in caplog.text
    assert same(checkpoint, whole_run)
    assert not list(tmp_path.rglob("*.tmp"))


def scaled_from(scale: float, folder: Path) -> tuple[State, torch.amp.GradScaler]:
    """The state of a training in float16, and what scales its gradients."""
    model, scaler = torch.nn.Linear(1, 1), torch.amp.GradScaler("cpu", init_scale=scale)
    rest = torch.optim.AdamW(model.parameters()), scaler, torch.Generator(), Journal(9, None)
    return State(folder, model, Average(model, 0.9), *rest), scaler


def test_a_resumed_training_scales_its_gradients_as_before(tmp_path):
    state, scaler = scaled_from(32.0, tmp_path)
    state.save(4)
    resumed, fresh = scaled_from(2.0, tmp_path)
    assert resumed.resume() == 4
    assert fresh.state_dict() == scaler.state_dict()
    assert fresh.get_scale() == 32.0


@pytest.mark.parametrize("name", ["000000004.safetensors", "000000004.json"])
def test_a_damaged_save_is_passed_over_for_the_one_before(
    name, world, tmp_path, whole_run, stopped_at, caplog
):
    state = stopped_at(4)
    (damaged,) = state.rglob(name)
    content = bytearray(damaged.read_bytes())
    content[-20] ^= 1
    damaged.write_bytes(content)
    with caplog.at_level("INFO"):
        checkpoint = world.train(tmp_path / "a", state=state, **BRIEF)
    assert "000000004 is damaged and passed over" in caplog.text
    assert "resumed at step 2 of 6" in caplog.text
    assert same(checkpoint, whole_run)


def test_two_saves_are_kept_until_the_checkpoint_stands(world, tmp_path):
    state = tmp_path / "timeline.state"
    world.train(tmp_path / "a", state=state, **BRIEF)
    (own,) = state.iterdir()
    assert {path.stem for path in own.iterdir()} == {"000000004", "000000006"}
    assert {path.suffix for path in own.iterdir()} == {".safetensors", ".json"}
    finished(state)
    assert not state.exists()


@pytest.fixture
def folder_of(monkeypatch, tmp_path):
    """The folder that a training would save in, without training."""

    def asked(world, **changes) -> str:
        def look(processes, backend, task, *args):
            state, curves = args[-2:]
            assert state.name == curves.name
            raise Stopped(state.name)

        with monkeypatch.context() as patch:
            patch.setattr("mimeline.training.train.together", look)
            with pytest.raises(Stopped) as stopped:
                world.train(tmp_path / "a", tmp_path / "state", tmp_path / "curves", **changes)
        return str(stopped.value)

    return asked


def test_another_configuration_or_other_data_start_anew(world, other_world, folder_of):
    half = {"device": "cpu", "precision": "bfloat16"}
    changes = [{"seed": 1}, {"steps": 13}, {"learning_rate": 1e-3}, {"width": 32}]
    folders = [folder_of(world, **change) for change in [{}, {"hardware": half}, *changes]]
    folders.append(folder_of(other_world))
    assert len(set(folders)) == len(folders)


def test_how_often_it_saves_and_on_how_many_processes_are_no_reason_to_start_anew(world, folder_of):
    two = {"device": "cpu", "processes": 2}
    assert folder_of(world) == folder_of(world, save_every=7) == folder_of(world, hardware=two)


def test_a_full_disk_is_one_clear_error_and_the_last_save_stands(
    world, tmp_path, whole_run, stopped_at, monkeypatch
):
    state = stopped_at(2)
    (own,) = state.iterdir()
    before = {path.name: path.read_bytes() for path in own.iterdir()}

    def write_some(path, content):
        with path.open("wb") as file:
            file.write(content[:100])
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_bytes", write_some)
        with pytest.raises(NoRoom, match=f"{own.name}: found no space left on its disk"):
            world.train(tmp_path / "a", state=state, **BRIEF)
    assert {path.name: path.read_bytes() for path in own.iterdir()} == before
    assert same(world.train(tmp_path / "a", state=state, **BRIEF), whole_run)


def test_the_curves_of_a_resumed_training_have_each_point_once(world, tmp_path, monkeypatch):
    from tensorboardX.proto.event_pb2 import Event

    state, curves = tmp_path / "state", tmp_path / "tensorboard"
    note = State.save

    def stop(self, step):
        if step == 2 * SAVED:  # after rows that the last save does not hold
            raise Stopped
        note(self, step)

    with monkeypatch.context() as patch:
        patch.setattr(State, "save", stop)
        with pytest.raises(Stopped):
            world.train(tmp_path / "a", state=state, tensorboard=curves, **BRIEF)
    assert [step for step, _ in points(curves, Event)["loss"]] == [3]
    checkpoint = world.train(tmp_path / "a", state=state, tensorboard=curves, **BRIEF)
    rows, found = losses(checkpoint), points(curves, Event)
    assert set(found) == {*rows.columns, "steps_per_second"} - {"step", "seconds"}
    for name in set(rows.columns) & set(found):
        assert [step for step, _ in found[name]] == rows["step"].tolist()
        assert [value for _, value in found[name]] == pytest.approx(rows[name].tolist())


def points(folder: Path, event_type) -> dict[str, list[tuple[int, float]]]:
    """The scalars of all event files below a folder, (step, value) by name."""
    found: dict[str, list[tuple[int, float]]] = {}
    for file in folder.rglob("events.out.tfevents.*"):
        content, at = file.read_bytes(), 0
        while at < len(content):  # length (8), its checksum (4), the event, its checksum (4)
            length = int.from_bytes(content[at : at + 8], "little")
            event = event_type.FromString(content[at + 12 : at + 12 + length])
            for value in event.summary.value:
                found.setdefault(value.tag, []).append((event.step, value.simple_value))
            at += 12 + length + 4
    return found
