"""Shared by all tests: one thread, the real recordings where they are, a tiny toy world."""

import os
import sys

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ.setdefault(name, "1")  # before numpy loads

from pathlib import Path
from types import SimpleNamespace
from typing import NamedTuple

import pytest
from xdist.scheduler import LoadScopeScheduling

CHECKOUT = Path(__file__).parents[1]
os.environ.setdefault("MIMELINE_REAL_DATA", str(CHECKOUT.parent / "shared" / "data"))


class ByRoom(LoadScopeScheduling):
    """Tests of a room, a folder of tests/, share fixtures: they run in one process."""

    def _split_scope(self, nodeid: str) -> str:
        return nodeid.partition("::")[0].split("/")[1]


def pytest_xdist_make_scheduler(config, log):
    return ByRoom(config, log)


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items):
    """The room that takes the longest comes first."""
    items.sort(key=lambda item: "/workflow/" not in item.nodeid)


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
