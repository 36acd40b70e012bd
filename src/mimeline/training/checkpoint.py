"""A checkpoint: a folder with the weights, how to build the model, its channels, its origin."""

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import safetensors.torch
from safetensors import SafetensorError
from torch import Tensor, nn

from mimeline import __version__, tables
from mimeline.atomic import whole
from mimeline.dataset.windows import Normaliser
from mimeline.errors import MimelineError
from mimeline.tracking.take import Origin
from mimeline.training.families import FAMILIES
from mimeline.training.loop import Run
from mimeline.vocabulary import CHANNELS

FORMAT = 2  # of the folder; rises when what lies in it changes its meaning
WEIGHTS, CONFIG, COLUMNS = "model.safetensors", "config.json", "channels.json"
PROVENANCE, LOSSES = "provenance.json", "log.parquet"
PACKAGES = ("accelerate", "numpy", "pandas", "pyarrow", "safetensors", "torch")
NUMBERS = ("mean", "std", "low", "high")  # of a channel, in its unit
AVERAGED, RAW = "ema.", "raw."


class BadCheckpoint(MimelineError):
    """A checkpoint is missing, damaged, of another version or of other channels."""


class EmptyCheckpoint(BadCheckpoint):
    """A checkpoint holds no model, because there was too little data to train one."""


@dataclass(frozen=True)
class Trained:
    """A model read from a checkpoint, ready to predict.

    family: its name in FAMILIES. normaliser: its channels in order, with mean and std. train: the
    config keys that it was trained with. fps: frames per second of most of its training clips.
    origins: channel → how its training clips had it, where that is known.
    """

    family: str
    model: nn.Module
    normaliser: Normaliser
    train: dict[str, Any]
    fps: Fraction
    origins: dict[str, Origin]


def provenance(inputs: Iterable[str | Path], seed: int) -> dict[str, Any]:
    """What a training saw: the sha256 of its input files, our version, the seed, the packages'."""
    return {
        "mimeline": __version__,
        "seed": seed,
        "packages": {name: version(name) for name in PACKAGES},
        "inputs": [{"file": str(path), "sha256": _sha256(path)} for path in inputs],
    }


def save(
    folder: str | Path,
    run: Run,
    *,
    family: str,
    model: Mapping[str, Any],
    train: Mapping[str, Any],
    normaliser: Normaliser,
    fps: Fraction,
    origins: Mapping[str, Origin],
    origin: Mapping[str, Any],
) -> None:
    """Write a finished training.

    model: the constructor's plain values but the channels, which the normaliser names. train: the
    config keys. fps: frames per second of the training clips. origins: channel → how these had it.
    origin: from `provenance`.
    """
    folder = _emptied(folder)
    weights = {AVERAGED + name: value for name, value in run.average.state_dict().items()}
    weights |= {RAW + name: value for name, value in run.model.state_dict().items()}
    config = {"format": FORMAT, "mimeline": __version__, "family": family, "fps": str(fps)}
    config |= {"model": dict(model), "train": dict(train)}
    channels = [
        {"name": name, **{key: float(getattr(normaliser, key)[i]) for key in NUMBERS}}
        | _told(origins.get(name))
        for i, name in enumerate(normaliser.channels)
    ]
    content = safetensors.torch.save({name: value.contiguous() for name, value in weights.items()})
    with whole(folder / WEIGHTS) as temporary:
        temporary.write_bytes(content)  # unlike save_file's, a full disk is an OSError
    _write_json(folder / CONFIG, config)
    _write_json(folder / COLUMNS, {"channels": channels})
    _write_json(folder / PROVENANCE, origin)
    tables.write(tables.LOSSES, run.losses, folder / LOSSES)


def save_empty(folder: str | Path, why: str, origin: Mapping[str, Any]) -> None:
    """Write that nothing was trained, and why."""
    folder = _emptied(folder)
    _write_json(folder / PROVENANCE, origin)
    tables.write(tables.LOSSES, tables.empty(tables.LOSSES), folder / LOSSES, reason=why)


def reason(folder: str | Path) -> str:
    """Why the checkpoint holds no model; the empty string where it holds one."""
    if not (Path(folder) / LOSSES).is_file():
        raise BadCheckpoint(
            folder,
            found="no such checkpoint",
            expected="a folder written by the train stage",
            remedy="Look at the path, or type snakemake --cores 2 --until train.",
        )
    try:
        return tables.reason(Path(folder) / LOSSES)
    except (ValueError, OSError) as error:
        raise _bad(Path(folder) / LOSSES, str(error), "a table in Parquet") from error


def losses(folder: str | Path) -> pd.DataFrame:
    """The losses of the training (tables.LOSSES)."""
    return tables.read(tables.LOSSES, Path(folder) / LOSSES)


def load(folder: str | Path, averaged: bool = True) -> Trained:
    """The model of a checkpoint, with its averaged or its last weights.

    Raises EmptyCheckpoint where nothing was trained, BadCheckpoint where the folder is missing,
    damaged, of another version, or of channels that are unknown or not those of its weights.
    """
    folder = Path(folder)
    if why := reason(folder):
        raise EmptyCheckpoint(
            folder,
            found=f"no model ({why})",
            expected="a trained model",
            remedy="Give it more data, then run the train stage again.",
        )
    config, described = _read_json(folder / CONFIG), _read_json(folder / COLUMNS)
    _check_version(folder / CONFIG, config)
    try:
        rows = described["channels"]
        _check_channels(folder / COLUMNS, [row["name"] for row in rows])
        normaliser = Normaliser(
            tuple(row["name"] for row in rows),
            *(np.array([row[key] for row in rows], np.float64) for key in NUMBERS),
        )
        model = FAMILIES[config["family"]].model(normaliser.channels, **config["model"])
        weights = _read_weights(folder / WEIGHTS)
        prefix = AVERAGED if averaged else RAW
        own = {k.removeprefix(prefix): v for k, v in weights.items() if k.startswith(prefix)}
        if broken := [name for name, value in own.items() if not value.isfinite().all()]:
            raise ValueError(f"weights that are no finite numbers in {', '.join(broken)}")
        model.load_state_dict(own)
        train, fps = dict(config["train"]), Fraction(config["fps"])
        origins = {
            row["name"]: Origin(str(row["origin"]), quality=row.get("quality"))
            for row in rows
            if "origin" in row
        }
    except (
        ArithmeticError,
        AttributeError,
        KeyError,
        RuntimeError,
        TypeError,
        ValueError,
    ) as error:
        raise _bad(folder, str(error), f"{WEIGHTS} and {COLUMNS} that fit {CONFIG}") from error
    model = model.eval().requires_grad_(False)
    return Trained(config["family"], model, normaliser, train, fps, origins)


def _told(origin: Origin | None) -> dict[str, Any]:
    if origin is None:
        return {}
    known = {} if origin.quality is None else {"quality": origin.quality}
    return {"origin": origin.text} | known


def _emptied(folder: str | Path) -> Path:
    """The folder, without the losses, which are written last: until then it is no checkpoint."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / LOSSES).unlink(missing_ok=True)
    return folder


def _check_version(file: Path, config: Mapping[str, Any]) -> None:
    found, writer = config.get("format"), config.get("mimeline", "an unknown version")
    if found == FORMAT and config.get("family") in FAMILIES:
        return
    later = isinstance(found, int) and found > FORMAT
    raise BadCheckpoint(
        file,
        found=f"format {found} of family {config.get('family')}, written by mimeline {writer}",
        expected=f"format {FORMAT} of one of {', '.join(FAMILIES)}, which mimeline {__version__} "
        "reads",
        remedy="Install that version or a later one, or delete the folder and train again."
        if later
        else "Delete the folder and run the train stage again, or install the version that "
        "wrote it.",
    )


def _check_channels(file: Path, found: Sequence[str]) -> None:
    if unknown := [name for name in found if name not in CHANNELS]:
        raise BadCheckpoint(
            file,
            found=f"the channel{'s'[: len(unknown) > 1]} {', '.join(unknown)}",
            expected=f"channels that mimeline {__version__} knows",
            remedy="Use a model of these, or the version that wrote it.",
        )


def _sha256(path: str | Path) -> str:
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _write_json(path: Path, value: Mapping[str, Any]) -> None:
    with whole(path) as temporary:
        text = json.dumps(value, indent=2, ensure_ascii=False) + "\n"
        temporary.write_text(text, encoding="utf-8")


def _read_json(path: Path) -> dict[str, Any]:
    try:
        value = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise _bad(path, str(error), "a JSON file") from error
    if not isinstance(value, dict):
        raise _bad(path, f"a JSON {type(value).__name__}", "a JSON object")
    return value


def _read_weights(path: Path) -> dict[str, Tensor]:
    try:
        return safetensors.torch.load_file(path)
    except (OSError, SafetensorError) as error:
        raise _bad(path, f"a damaged file: {error}", "a whole file of weights") from error


def _bad(file: str | Path, found: str, expected: str) -> BadCheckpoint:
    return BadCheckpoint(
        file,
        found=found,
        expected=expected,
        remedy="Delete the folder and run the train stage again.",
    )
