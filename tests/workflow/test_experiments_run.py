"""The experiments on the results of a finished run: no part of it, and nothing of it runs again."""

import shutil

import pytest
import yaml

from mimeline import tables
from mimeline.vocabulary import SERIES_REGIONS

GRID = {"sweep": {"n_clusters": [3], "beta": [40.0]}, "experiments": {"seeds": 1}}


@pytest.fixture
def tried(toy_run, tmp_path):
    results = toy_run.root / "results" / "experiments"
    change = tmp_path / "grid.yaml"
    change.write_text(yaml.safe_dump(GRID))
    try:
        yield toy_run.run("experiments", config=("tests/workflow/tiny.yaml", str(change))), results
    finally:
        shutil.rmtree(results, ignore_errors=True)


def test_the_experiments_on_a_finished_run_end_with_their_page_and_fit_nothing_else(tried):
    done, results = tried
    said = done.stdout + done.stderr
    assert done.returncode == 0, said
    assert "mimeline: the page is results/experiments/index.html" in said
    assert "4 of 4 steps" in said
    page = (results / "index.html").read_text(encoding="utf-8")
    assert "claspy/bin/pip install claspy" in page
    summary = tables.read(tables.METRICS, results / "summary.parquet")
    assert set(summary["model"]) == {"experiments"}
    for region in SERIES_REGIONS:
        rows = tables.read(tables.EXPERIMENTS, results / f"{region}.parquet")
        names = set(zip(rows["experiment"], rows["setting"], strict=True))
        assert {("reference", "configured"), ("clusters", "3"), ("beta", "40")} <= names
        own = summary[summary["metric"] == f"f1_{region}"]
        assert {f"{experiment}/{setting}" for experiment, setting in names} == set(own["variant"])
        assert own["value"].between(0, 1).all()
        assert f'<i class="line {region}">' in page
