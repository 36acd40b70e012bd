"""The sweep on the results of a finished run: no part of it, and nothing of it runs again."""

import shutil

import pytest
import yaml

from mimeline import tables
from mimeline.vocabulary import SERIES_REGIONS

GRID = {"sweep": {"n_clusters": [3], "beta": [40.0], "seeds": 1}}


@pytest.fixture
def swept(toy_run, tmp_path):
    results = toy_run.root / "results" / "sweep"
    change = tmp_path / "grid.yaml"
    change.write_text(yaml.safe_dump(GRID))
    try:
        yield toy_run.run("sweep", config=("tests/workflow/tiny.yaml", str(change))), results
    finally:
        shutil.rmtree(results, ignore_errors=True)


def test_a_sweep_of_a_finished_run_ends_with_its_page_and_fits_nothing_else(swept):
    done, results = swept
    said = done.stdout + done.stderr
    assert done.returncode == 0, said
    assert "mimeline: the page is results/sweep/index.html" in said
    assert "4 of 4 steps" in said
    page = (results / "index.html").read_text(encoding="utf-8")
    for region in SERIES_REGIONS:
        rows = tables.read(tables.SWEEP, results / f"{region}.parquet")
        assert set(rows["n_clusters"]) == {3, 4}  # the grid and the configured one
        assert set(rows["beta"]) == {20.0, 40.0}
        assert rows["f1"].notna().all()
        assert f"{region}: {{n_clusters" in page
