import errno
import json
import shutil
from importlib.metadata import version
from pathlib import Path

import pytest
import safetensors.torch
import torch

from mimeline import __version__
from mimeline.room import NoRoom
from mimeline.training.checkpoint import BadCheckpoint, EmptyCheckpoint, load, losses, reason


@pytest.fixture
def own(trained, tmp_path):
    """A copy of the checkpoint that a test may damage."""
    return shutil.copytree(trained, tmp_path / "own")


def test_a_checkpoint_holds_both_weights_the_channels_and_its_origin(trained, world):
    averaged, last = load(trained), load(trained, averaged=False)
    assert averaged.family == "timeline"
    assert averaged.normaliser.channels == ("browInnerUp", "jawOpen", "head_yaw_left")
    assert averaged.normaliser.std[0] == pytest.approx(0.4, abs=0.05)
    assert averaged.train["steps"] == 60
    assert averaged.fps == 30
    pairs = list(zip(averaged.model.parameters(), last.model.parameters(), strict=True))
    assert any(not torch.equal(a, b) for a, b in pairs)
    origin = json.loads((trained / "provenance.json").read_text())
    assert origin["mimeline"] == __version__
    assert origin["seed"] == 0
    assert origin["packages"]["torch"] == version("torch")
    assert [len(entry["sha256"]) for entry in origin["inputs"]] == [64] * 6
    assert losses(trained)["step"].iloc[-1] == 60
    assert reason(trained) == ""


def test_nothing_in_a_checkpoint_is_a_pickle(trained):
    assert {path.suffix for path in trained.iterdir()} == {".safetensors", ".json", ".parquet"}


def test_a_missing_checkpoint_is_a_typed_error(tmp_path):
    with pytest.raises(BadCheckpoint, match="no such checkpoint"):
        load(tmp_path / "nowhere")


def test_truncated_weights_are_a_typed_error(own):
    weights = own / "model.safetensors"
    weights.write_bytes(weights.read_bytes()[:-100])
    with pytest.raises(BadCheckpoint, match="Delete the folder and run the train stage again"):
        load(own)


@pytest.mark.parametrize("name", ["model.safetensors", "config.json", "channels.json"])
def test_an_absent_file_is_a_typed_error(own, name):
    (own / name).unlink()
    with pytest.raises(BadCheckpoint):
        load(own)


@pytest.mark.parametrize("name", ["config.json", "channels.json"])
@pytest.mark.parametrize("content", ["{", "[]", "{}", '{"channels": 3}'])
def test_a_damaged_description_is_a_typed_error(own, name, content):
    (own / name).write_text(content)
    with pytest.raises(BadCheckpoint):
        load(own)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"format": 99, "mimeline": "9.1"}, r"format 99.*written by mimeline 9\.1.*Install that"),
        ({"format": 1}, "format 1 .*run the train stage again"),
        ({"family": "oracle"}, "family oracle"),
    ],
)
def test_another_version_is_a_typed_error_that_says_which_and_what_to_do(own, changes, message):
    config = json.loads((own / "config.json").read_text())
    (own / "config.json").write_text(json.dumps(config | changes))
    with pytest.raises(BadCheckpoint, match=message):
        load(own)


def test_channels_that_nobody_knows_are_a_typed_error_that_names_them(own):
    described = json.loads((own / "channels.json").read_text())
    described["channels"][0]["name"] = "noseWiggle"
    (own / "channels.json").write_text(json.dumps(described))
    with pytest.raises(BadCheckpoint, match="the channel noseWiggle, expected channels that"):
        load(own)


def test_channels_of_another_model_are_a_typed_error(own):
    described = json.loads((own / "channels.json").read_text())
    (own / "channels.json").write_text(json.dumps({"channels": described["channels"][:-1]}))
    with pytest.raises(BadCheckpoint, match="that fit config"):
        load(own)


def damage(weights, how):
    """The weights' file with that damage."""
    tensors = safetensors.torch.load_file(weights)
    if how == "garbage":
        weights.write_bytes(b"\xff" * 200)
    elif how == "empty":
        weights.write_bytes(b"")
    elif how == "a header of nonsense":
        content = weights.read_bytes()
        weights.write_bytes(content[:8] + b"?" * 40 + content[48:])
    elif how == "not finite":
        tensors["ema.keep.weight"][0, 0] = float("nan")
        safetensors.torch.save_file(tensors, weights)
    elif how == "another shape":
        tensors["ema.keep.bias"] = tensors["ema.keep.bias"][:-1].clone()
        safetensors.torch.save_file(tensors, weights)
    else:
        del tensors["ema.keep.bias"]
        safetensors.torch.save_file(tensors, weights)


@pytest.mark.parametrize(
    "how",
    ["garbage", "empty", "a header of nonsense", "not finite", "another shape", "one is missing"],
)
def test_damaged_weights_are_a_typed_error(own, how):
    damage(own / "model.safetensors", how)
    with pytest.raises(BadCheckpoint, match="Delete the folder and run the train stage again"):
        load(own)


def test_a_full_disk_at_the_end_is_told_and_costs_no_step(world, tmp_path, monkeypatch):
    write = Path.write_bytes

    def full(path, content):
        if path.name.startswith("model.safetensors"):
            write(path, content[:100])
            raise OSError(errno.EDQUOT, "Disk quota exceeded")
        return write(path, content)

    state, steps = tmp_path / "state", {"steps": 3}
    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_bytes", full)
        with pytest.raises(NoRoom, match="room for the checkpoint"):
            world.train(tmp_path / "new" / "timeline", state=state, **steps)
    assert not list((tmp_path / "new").rglob("model.safetensors*"))
    monkeypatch.setattr("mimeline.training.loop.learning_rate", None)  # no step is done again
    assert load(world.train(tmp_path / "new" / "timeline", state=state, **steps)).fps == 30


def test_clips_of_several_frame_rates_are_told(of_two_rates, tmp_path, caplog):
    assert load(of_two_rates.train(tmp_path / "timeline", steps=1)).fps == 25
    assert "differ in frame rate: 25 fps (2), 60 fps (1)" in caplog.text


def test_weights_of_another_size_are_a_typed_error(own):
    config = json.loads((own / "config.json").read_text())
    config["model"]["width"] = 32
    (own / "config.json").write_text(json.dumps(config))
    with pytest.raises(BadCheckpoint):
        load(own)


def test_damaged_losses_are_a_typed_error(own):
    (own / "log.parquet").write_bytes(b"not parquet")
    with pytest.raises(BadCheckpoint):
        load(own)


def test_an_empty_checkpoint_tells_why(empty):
    assert "0 valid frames" in reason(empty)
    assert losses(empty).empty
    assert {path.name for path in empty.iterdir()} == {"log.parquet", "provenance.json"}
    with pytest.raises(EmptyCheckpoint, match="0 valid frames"):
        load(empty)


def test_tables_without_a_row_give_an_empty_checkpoint(bare):
    with pytest.raises(EmptyCheckpoint, match="0 valid frames of 0 channels"):
        load(bare)
