"""Shared by all tests: one thread, the real recordings where they are, a tiny toy world."""

import os
import sys

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ.setdefault(name, "1")  # before numpy loads

from pathlib import Path
from types import SimpleNamespace
from typing import NamedTuple

import pytest

CHECKOUT = Path(__file__).parents[1]
os.environ.setdefault("MIMELINE_REAL_DATA", str(CHECKOUT.parent / "shared" / "data"))


@pytest.hookimpl(tryfirst=True)  # the marks are read in the same hook
def pytest_collection_modifyitems(items):
    """A room's tests share its fixtures, so they run in one process; the longest come first."""
    items.sort(key=lambda item: room(item) != "workflow")
    for item in items:
        item.add_marker(pytest.mark.xdist_group(room(item)))


def room(item: pytest.Item) -> str:
    """The folder of tests/ that a test lies in, or its own file."""
    return item.path.relative_to(Path(__file__).parent).parts[0]


@pytest.fixture(scope="session")
def real_data() -> Path:
    """Folder of real recordings; tests that need it skip where it is absent."""
    folder = Path(os.environ["MIMELINE_REAL_DATA"])
    if not folder.is_dir():
        pytest.skip(f"no real recordings at {folder}; set MIMELINE_REAL_DATA")
    return folder


@pytest.fixture(scope="session")
def toy_world(tmp_path_factory) -> SimpleNamespace:
    """A small toy world in files: data and truth folders."""
    from mimeline.toy import make

    root = tmp_path_factory.mktemp("toy")
    make(root / "data", root / "truth", people=8, clips=30, seed=3, video_share=0.1, video_px=64)
    return SimpleNamespace(data=root / "data", truth=root / "truth")


class Said(NamedTuple):
    """What a command left: its exit code, standard output and standard error."""

    code: int
    out: str
    err: str


@pytest.fixture
def mimeline(monkeypatch, capsys):
    """The command line in this process: its words, as many as you like → Said."""
    from mimeline import cli

    def run(*words) -> Said:
        monkeypatch.setattr(sys, "argv", ["mimeline", *map(str, words)])
        with pytest.raises(SystemExit) as left:
            cli.main()
        (out, err), code = capsys.readouterr(), left.value.code
        return Said(1, out, f"{err}{code}\n") if isinstance(code, str) else Said(code, out, err)

    return run
