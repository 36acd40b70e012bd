"""Shared by all tests: one thread, the real recordings where they are, a tiny toy world."""

import os

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ.setdefault(name, "1")  # before numpy loads

from pathlib import Path
from types import SimpleNamespace

import pytest

CHECKOUT = Path(__file__).parents[1]
os.environ.setdefault("MIMELINE_REAL_DATA", str(CHECKOUT.parent / "shared" / "data"))


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
