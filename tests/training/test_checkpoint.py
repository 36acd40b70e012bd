import json
import shutil
from importlib.metadata import version

import pytest
import torch

from mimeline import __version__
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
    pairs = list(zip(averaged.model.parameters(), last.model.parameters(), strict=True))
    assert any(not torch.equal(a, b) for a, b in pairs)
    origin = json.loads((trained / "provenance.json").read_text())
    assert origin["mimeline"] == __version__
    assert origin["seed"] == 0
    assert origin["packages"]["torch"] == version("torch")
    assert [len(entry["sha256"]) for entry in origin["inputs"]] == [64] * 4
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


@pytest.mark.parametrize(("key", "value"), [("format", 99), ("family", "oracle")])
def test_another_version_is_a_typed_error_that_says_which(own, key, value):
    config = json.loads((own / "config.json").read_text())
    (own / "config.json").write_text(json.dumps(config | {key: value}))
    with pytest.raises(BadCheckpoint, match=str(value)):
        load(own)


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
