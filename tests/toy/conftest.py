from pathlib import Path
from types import SimpleNamespace

import pytest

from mimeline.toy import make, simulate

PEOPLE, CLIPS, SEED = 8, 40, 3
VIDEO = {"video_share": 0.15, "video_px": 64}


@pytest.fixture(scope="session")
def world():
    return simulate(PEOPLE, CLIPS, SEED)


@pytest.fixture(scope="session")
def written(tmp_path_factory) -> SimpleNamespace:
    """A world with faults on disk; root holds nothing but its two folders."""
    root: Path = tmp_path_factory.mktemp("toy") / "deep" / "root"
    data, truth = root / "data", root / "truth"
    make(data, truth, PEOPLE, CLIPS, SEED, **VIDEO)
    return SimpleNamespace(root=root, data=data, truth=truth)
