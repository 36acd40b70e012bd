"""The sweep and the experiments on a finished run: no part of it, and nothing of it runs again."""

import shutil
from types import SimpleNamespace

import pytest
import yaml

from mimeline import tables
from mimeline.vocabulary import SERIES_REGIONS

GRID = {
    "sweep": {"n_clusters": [3], "beta": [40.0], "seeds": 1},
    "experiments": {"seeds": 1},
}


@pytest.fixture(scope="module")
def studied(toy_run, tmp_path_factory):
    """What the run of both said, and the folder of each."""
    folders = {name: toy_run.root / "results" / name for name in ("sweep", "experiments")}
    change = tmp_path_factory.mktemp("grid") / "grid.yaml"
    change.write_text(yaml.safe_dump(GRID))
    try:
        done = toy_run.run(*folders, config=("tests/workflow/tiny.yaml", str(change)))
        assert done.returncode == 0, done.stdout + done.stderr
        yield SimpleNamespace(said=done.stdout + done.stderr, **folders)
    finally:
        for folder in folders.values():
            shutil.rmtree(folder, ignore_errors=True)


def test_they_fit_nothing_of_the_run_again(studied):
    assert "8 of 8 steps" in studied.said  # three regions and a page, of each


def test_the_sweep_ends_with_its_page(studied):
    assert "mimeline: the page is results/sweep/index.html" in studied.said
    page = (studied.sweep / "index.html").read_text(encoding="utf-8")
    for region in SERIES_REGIONS:
        rows = tables.read(tables.SWEEP, studied.sweep / f"{region}.parquet")
        assert set(rows["n_clusters"]) == {3, 4}  # the grid and the configured one
        assert set(rows["beta"]) == {20.0, 40.0}
        assert rows["f1"].notna().all()
        assert f"{region}: {{n_clusters" in page


def test_the_experiments_end_with_their_page(studied):
    assert "mimeline: the page is results/experiments/index.html" in studied.said
    page = (studied.experiments / "index.html").read_text(encoding="utf-8")
    assert "claspy/bin/pip install claspy" in page
    summary = tables.read(tables.METRICS, studied.experiments / "summary.parquet")
    assert set(summary["model"]) == {"experiments"}
    for region in SERIES_REGIONS:
        rows = tables.read(tables.EXPERIMENTS, studied.experiments / f"{region}.parquet")
        names = set(zip(rows["experiment"], rows["setting"], strict=True))
        assert {("reference", "configured"), ("clusters", "3"), ("beta", "40")} <= names
        own = summary[summary["metric"] == f"f1_{region}"]
        assert {f"{experiment}/{setting}" for experiment, setting in names} == set(own["variant"])
        assert own["value"].between(0, 1).all()
        assert f'<i class="line {region}">' in page
