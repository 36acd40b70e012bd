"""The model that somebody names, and how its run would ask it."""

from pathlib import Path

import pytest

from mimeline.errors import BadConfig
from mimeline.generation.model_of_run import checkpoint_of, sampling_of
from mimeline.run import remember
from mimeline.training.checkpoint import BadCheckpoint


@pytest.fixture
def results(tmp_path) -> Path:
    for name in ("timeline", "other"):
        (tmp_path / "results" / "train" / name / "checkpoint").mkdir(parents=True)
    return tmp_path / "results"


def test_a_model_is_named_as_in_its_run_or_by_its_folder(results, tmp_path, monkeypatch):
    folder = results / "train" / "timeline" / "checkpoint"
    assert checkpoint_of("timeline", results) == folder
    assert checkpoint_of(str(folder), tmp_path / "elsewhere") == folder
    monkeypatch.chdir(folder.parent)
    assert checkpoint_of("checkpoint", tmp_path / "elsewhere") == Path("checkpoint")
    assert checkpoint_of("./checkpoint", results) == Path("./checkpoint")


@pytest.mark.parametrize("name", ["talking", "../train/timeline", "", "nowhere/checkpoint"])
def test_a_model_that_is_not_there_ends_with_those_that_are(results, name):
    with pytest.raises(BadCheckpoint, match="other, timeline"):
        checkpoint_of(name, results)


def test_a_model_is_asked_as_its_run_says_else_by_the_defaults(results):
    folder = checkpoint_of("timeline", results)
    assert sampling_of(folder, []).guidance == 2.0
    remember(results, {"evaluate": {"timeline": {"guidance": 3.5}}}, [], [])
    assert sampling_of(folder, []).guidance == 3.5
    assert sampling_of(folder, ["guidance=1", "region_guidance={mouth: 4}"]).guidance == 1
    assert sampling_of(folder, ["region_guidance={mouth: 4}"]).region_guidance == {"mouth": 4}
    assert sampling_of(folder, ["evaluate.timeline.sampler=ddim"]).sampler == "ddim"


@pytest.mark.parametrize("told", [{"evaluate": 3}, {"evaluate": {"timeline": []}}, {}])
def test_a_run_that_tells_nothing_is_as_none(results, told):
    remember(results, told, [], [])
    assert sampling_of(checkpoint_of("timeline", results), []).sampler == "dpmpp_2m"


@pytest.mark.parametrize("text", ["guidance", "seed=3", "x=1", "sampler=euler", "overlap=2"])
def test_a_key_or_value_that_there_is_not_is_told(results, text):
    with pytest.raises(BadConfig):
        sampling_of(checkpoint_of("timeline", results), [text])
