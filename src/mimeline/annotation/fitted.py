"""What a region's model folder tells without the model being loaded."""

import json
from pathlib import Path

from mimeline.errors import BadFile

CHANNELS_FILE = "channels.json"
FINGERPRINT_FILE = "fingerprint.txt"


def is_fitted(folder: Path) -> bool:
    """Whether segment wrote a model there; snakemake leaves a time stamp in any folder."""
    return (Path(folder) / CHANNELS_FILE).is_file()


def read_fingerprint(folder: Path) -> str:
    """What a label file calls the model. Raises BadFile where the folder does not tell."""
    try:
        return (Path(folder) / FINGERPRINT_FILE).read_text(encoding="utf-8").strip()
    except (OSError, ValueError) as error:
        raise broken(folder, error) from error


def read_channels(folder: Path) -> tuple[str, ...]:
    """The channels that the model takes. Raises BadFile where the folder does not tell."""
    try:
        return tuple(json.loads((Path(folder) / CHANNELS_FILE).read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError) as error:
        raise broken(folder, error) from error


def broken(folder: Path, error: Exception) -> BadFile:
    """The complaint about a folder that holds no whole model."""
    return BadFile(
        folder,
        found=str(error),
        expected="a fitted model",
        remedy="Delete the folder and run segment again.",
    )
