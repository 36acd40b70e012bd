"""Spoiled takes of every format: a reader gives a sound take or the one error that users see.

MIMELINE_FUZZ_CASES sets how many takes of each format are spoiled, anew at each run.
"""

import os
import shutil
import signal
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mimeline import tables
from mimeline.errors import MimelineError
from mimeline.tracking.readers import READERS
from mimeline.tracking.take import MOST_FRAMES, Take
from mimeline.vocabulary import CHANNELS, EXPRESSIONS

from .mutations import spoil

GOLDEN = Path(__file__).parent / "golden"
CASES = os.environ.get("MIMELINE_FUZZ_CASES")
HANGS_S = 20.0


@contextmanager
def no_hang() -> Iterator[None]:
    def ring(number, frame):
        raise TimeoutError(f"still reading after {HANGS_S} s")

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, HANGS_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def tree(folder: Path) -> dict[str, bytes | str]:
    """What lies in a folder, to the byte; links as what they point to."""
    found = {}
    for path in sorted(folder.rglob("*")):
        name = str(path.relative_to(folder))
        if path.is_symlink():
            found[name] = str(path.readlink())
        else:
            found[name] = path.read_bytes() if path.is_file() else "folder"
    return found


def keeps_its_contract(take: Take) -> None:
    """Asserts what tables and stages rely on."""
    motion, n_frames = take.motion, len(take.motion)
    assert 0 < n_frames <= MOST_FRAMES
    assert take.fps > 0
    assert motion["frame"].tolist() == list(range(n_frames))
    assert set(motion.columns) == {"frame", "valid", "confidence", "tracker_loss", *CHANNELS}
    assert motion["valid"].dtype == bool
    valid = motion["valid"].to_numpy()
    values = motion[list(CHANNELS)].to_numpy(np.float32)  # (n, 57)
    assert np.isnan(values[~valid]).all()
    assert not np.isinf(values).any()
    expressions, angles = np.split(values, [len(EXPRESSIONS)], axis=1)
    assert tuple(CHANNELS)[: len(EXPRESSIONS)] == EXPRESSIONS
    assert not ((expressions < -1) | (expressions > 2)).any()
    assert not (np.abs(angles) > np.pi + 1e-3).any()
    assert not np.isinf(motion[["confidence", "tracker_loss"]].to_numpy(float)).any()
    assert set(take.origins) <= set(CHANNELS)
    for name, rows in take.coefficients.items():
        keys = ["clip_id", "frame"]
        assert [*keys, *rows.columns] == tables.COEFFICIENTS[name].schema.names
        assert len(rows) == n_frames
        numbers = rows.to_numpy(np.float32)
        assert not np.isinf(numbers).any()
        assert np.isnan(numbers[~valid]).all()


@pytest.fixture(scope="module")
def room() -> Iterator[Path]:
    """A folder to spoil takes in, where the process works, too."""
    here = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        yield Path(folder)
        os.chdir(here)


@pytest.mark.parametrize("format", sorted(f.name for f in GOLDEN.iterdir() if f.name in READERS))
def test_a_spoiled_take_is_read_soundly_or_refused(format, room):
    options = yaml.safe_load((GOLDEN / format / "options.yaml").read_text())
    takes = sorted(path for path in (GOLDEN / format).iterdir() if path.name != "options.yaml")
    reader = READERS[format]

    @settings(
        max_examples=int(CASES or 100),
        deadline=None,
        database=None,
        derandomize=CASES is None,
        suppress_health_check=list(HealthCheck),
    )
    @given(st.data())
    def spoil_and_read(data):
        shutil.rmtree(room / "work", ignore_errors=True)
        outside = room / "work" / "outside.txt"
        outside.parent.mkdir()
        outside.write_text("not yours")
        golden = data.draw(st.sampled_from(takes))
        path = outside.parent / "takes" / golden.name
        path.parent.mkdir()
        (shutil.copytree if golden.is_dir() else shutil.copyfile)(golden, path)
        for _ in range(data.draw(st.integers(1, 3))):
            spoil(path, outside, data.draw)
        before = tree(room)
        for bad_values in ("fail", "mask"):
            with no_hang():
                assert reader.holds(path) in (True, False)
                with suppress(MimelineError):
                    keeps_its_contract(reader.read(path, bad_values=bad_values, **options))
        assert tree(room) == before

    spoil_and_read()
