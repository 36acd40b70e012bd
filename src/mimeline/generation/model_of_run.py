"""The model that somebody names, and how it is to be asked."""

from collections.abc import Iterable
from dataclasses import fields
from pathlib import Path

from mimeline.config import validate, value_of
from mimeline.errors import BadConfig
from mimeline.generation.timeline import Sampling
from mimeline.run import recall
from mimeline.training.checkpoint import BadCheckpoint

FOLDER, CHECKPOINT = "train", "checkpoint"


def checkpoint_of(model: str, results: Path) -> Path:
    """The checkpoint of a model: its folder, or the name that it has in a run.

    Raises BadCheckpoint where neither is there.
    """
    named = results / FOLDER / model / CHECKPOINT
    if model and "/" not in model and named.is_dir():
        return named
    if model and Path(model).is_dir():
        return Path(model)
    there = sorted(folder.parent.name for folder in (results / FOLDER).glob(f"*/{CHECKPOINT}"))
    raise BadCheckpoint(
        f"--model {model}",
        found="no such model",
        expected=f"a checkpoint's folder, or a model of {results}: {', '.join(there) or 'none'}",
        remedy="See that the path is right, train one with `snakemake --cores 2 --until train`, or "
        "name another run: --results FOLDER.",
    )


def sampling_of(checkpoint: Path, sets: Iterable[str]) -> Sampling:
    """How a model is asked: as its run says in evaluate.timeline, else the defaults.

    sets: KEY=VALUE, which go before. Raises BadConfig for a key or a value that there is not.
    """
    above = checkpoint.resolve().parents
    told = recall(above[2]).config if len(above) > 2 else {}
    keys = [field.name for field in fields(Sampling)]
    settled = {**validate({})["evaluate"]["timeline"], **_section(told)}
    for text in sets:
        key, equals, value = text.partition("=")
        key = key.strip().removeprefix("evaluate.timeline.")
        if key not in keys or not equals:
            raise BadConfig(
                "--set",
                place=text if equals else "",
                found="an unknown key" if equals else repr(text),
                expected=f"KEY=VALUE with one of {', '.join(keys)}",
                remedy="config/README.md explains them: evaluate.timeline.",
            )
        settled[key] = value_of(value)
    return Sampling(**{key: settled[key] for key in keys})


def _section(config: dict) -> dict:
    section = config.get("evaluate")
    own = section.get("timeline") if isinstance(section, dict) else None
    return own if isinstance(own, dict) else {}
