"""A small film, to be put under any name, and the way from a catalogue to its tables."""

import shutil
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from mimeline import tables
from mimeline.clips.catalogue import catalogue
from mimeline.config.catalogues import Catalogue
from mimeline.media.film import write_film


@pytest.fixture(scope="session")
def film(tmp_path_factory) -> Path:
    """Three seconds of 96 x 64 pixels at 25 frames per second."""
    path = tmp_path_factory.mktemp("film") / "film.mp4"
    pictures = (np.full((64, 96, 3), 3 * number, np.uint8) for number in range(75))
    write_film(path, pictures, Fraction(25))
    return path


@pytest.fixture(scope="session")
def put(film):
    """Puts the film at each path below a folder."""

    def put(folder: Path, *names: str) -> Path:
        for name in names:
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(film, folder / name)
        return folder

    return put


@pytest.fixture
def catalogued(tmp_path):
    """Runs the stage: a format's clips and ledger by clip, from a folder and the block's keys."""

    def catalogued(data: Path, format: str, cut_s: float | None = None, **options):
        out, ledger = tmp_path / "out" / "clips.parquet", tmp_path / "out" / "ledger.parquet"
        block = getattr(Catalogue(), format).model_dump() | options
        catalogue(data, [out], ledger, format, block, cut_s, None, {})
        return SimpleNamespace(
            clips=tables.read(tables.CLIPS, out).set_index("clip_id"),
            ledger=tables.read(tables.LEDGER, ledger).set_index("clip_id"),
        )

    return catalogued
