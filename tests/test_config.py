import json
import re
from pathlib import Path

import pytest
import yaml

from mimeline.config import Config, Section, default_yaml, json_schema, validate
from mimeline.errors import BadConfig

CONFIG = Path(__file__).parents[1] / "config"


def test_the_committed_files_agree_with_the_models():
    assert (CONFIG / "config.yaml").read_text(encoding="utf-8") == default_yaml()
    assert (CONFIG / "config.schema.json").read_text(encoding="utf-8") == json_schema()


def test_the_written_defaults_are_the_models_defaults():
    assert validate(yaml.safe_load(default_yaml())) == validate({})


def test_the_schema_forbids_unknown_keys_everywhere():
    schema = json.loads(json_schema())
    sections = [schema, *schema["$defs"].values()]
    assert all(section["additionalProperties"] is False for section in sections)


def keys(section: type[Section], prefix: str = ""):
    for name, field in section.model_fields.items():
        if isinstance(field.annotation, type) and issubclass(field.annotation, Section):
            yield from keys(field.annotation, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", field


@pytest.mark.parametrize(("key", "field"), list(keys(Config)), ids=lambda value: str(value)[:40])
def test_every_key_says_what_it_means(key, field):
    assert field.description


def test_the_readme_of_the_config_explains_every_key():
    text = (CONFIG / "README.md").read_text(encoding="utf-8")
    quoted = {name.split(".")[-1] for name in re.findall(r"`([\w.]+)`", text)}
    missing = [key for key, _ in keys(Config) if key.split(".")[-1] not in quoted]
    assert missing == []


@pytest.mark.parametrize(
    "example", sorted((CONFIG / "examples").glob("*.yaml")), ids=lambda p: p.stem
)
def test_the_examples_are_valid_and_have_a_results_folder_of_their_own(example):
    settled = validate(yaml.safe_load(example.read_text(encoding="utf-8")))
    assert settled["pathvars"]["results"] == f"results-{example.stem}"


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"segmnt": {}}, "key segmnt: found an unknown key, expected one of data_dir,"),
        ({"select": {"mins": 3}}, "key select.mins: found an unknown key, expected one of min_s,"),
        ({"select": {"min_s": "five"}}, "key select.min_s: found 'five', expected a valid number"),
        ({"select": {"min_s": 20}}, "expected select.min_s to be at most select.max_s"),
        ({"ingest": {"livelink": {"fps": 29.97}}}, "expected a rate like 30 or 30000/1001"),
        ({"split": {"val": 0.5, "test": 0.5}}, "to be below 1"),
        (
            {"sweep": {"n_clusters": []}},
            "key sweep.n_clusters: found [], expected at least one value",
        ),
        (
            {"fetch": {"url": "file:///films/{source_id}.mp4"}},
            "key fetch.url: found 'file:///films/{source_id}.mp4', expected an address of http",
        ),
        ({"fetch": {"url": "https://a.b/c"}}, "with {source_id} in it, or null"),
        ({"sweep": {"beta": []}}, "key sweep.beta: found [], expected at least one value"),
    ],
)
def test_a_mistake_is_told_in_one_line_with_its_key(values, message):
    with pytest.raises(ExceptionGroup) as caught:
        validate(values, "my.yaml")
    (problem,) = caught.value.exceptions
    assert isinstance(problem, BadConfig)
    assert message in str(problem)
    assert str(problem).startswith("my.yaml")
    assert "\n" not in str(problem)


SEEDS = [key for key, _ in keys(Config) if key.split(".")[-1] == "seed"]


@pytest.mark.parametrize("key", SEEDS)
@pytest.mark.parametrize("seed", [-1, 2**32])
def test_a_seed_that_no_generator_takes_is_refused(key, seed):
    values = seed
    for part in reversed(key.split(".")):
        values = {part: values}
    with pytest.raises(ExceptionGroup) as caught:
        validate(values)
    (problem,) = caught.value.exceptions
    assert f"key {key}: found {seed}, expected" in str(problem)


def test_every_mistake_is_told():
    with pytest.raises(ExceptionGroup) as caught:
        validate({"select": {"mins": 3}, "shards": "many", "segment": {"brow": {"beta": "inf"}}})
    found = {str(problem).split(":")[0] for problem in caught.value.exceptions}
    assert found == {
        "config, key select.mins",
        "config, key shards",
        "config, key segment.brow.beta",
    }


def test_numbers_given_as_text_on_the_command_line_become_numbers():
    settled = validate({"select": {"min_s": "3.5"}, "ingest": {"livelink": {"fps": 30}}})
    assert settled["select"]["min_s"] == 3.5
    assert settled["ingest"]["livelink"]["fps"] == "30"
