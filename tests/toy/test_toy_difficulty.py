"""The difficulty is frozen: these bounds are the agreement, the benchmark prints the figures."""

import importlib.util
from pathlib import Path

import pytest

from mimeline.toy import simulate
from mimeline.vocabulary import SERIES_REGIONS

_PATH = Path(__file__).parents[2] / "benchmarks" / "toy_difficulty.py"
_SPEC = importlib.util.spec_from_file_location("toy_difficulty", _PATH)
benchmark = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(benchmark)


@pytest.fixture(scope="module")
def default():
    return simulate(people=40, clips=120, seed=7)


@pytest.mark.parametrize("region", SERIES_REGIONS)
def test_single_frames_are_hard_and_time_makes_them_easy(default, region):
    scores = benchmark.region_scores(default, region)
    assert 0.80 < scores["gmm"] < 0.90
    assert scores["median"] > 0.94
    assert scores["clean"] > 0.95


def test_thresholds_do_well_on_closure_gaze_and_head_but_not_perfectly(default):
    for track, score in benchmark.threshold_scores(default).items():
        assert 0.85 < score < 0.985, track
