"""The sweep and the experiments on a finished run: no part of it, and nothing of it runs again."""

from mimeline import tables
from mimeline.vocabulary import SERIES_REGIONS


def test_they_fit_nothing_of_the_run_again(studied_run):
    _, said = studied_run
    assert "8 of 8 steps" in said, said  # three regions and a page, of each


def test_the_sweep_ends_with_its_page(studied_run):
    results, said = studied_run
    assert "mimeline: the page is results/sweep/index.html" in said
    page = (results / "sweep" / "index.html").read_text(encoding="utf-8")
    for region in SERIES_REGIONS:
        rows = tables.read(tables.SWEEP, results / "sweep" / f"{region}.parquet")
        assert set(rows["n_clusters"]) == {3, 4}  # the grid and the configured one
        assert set(rows["beta"]) == {20.0, 40.0}
        assert rows["f1"].notna().all()
        assert f"{region}: {{n_clusters" in page


def test_the_experiments_end_with_their_page(studied_run):
    results, said = studied_run
    assert "mimeline: the page is results/experiments/index.html" in said
    page = (results / "experiments" / "index.html").read_text(encoding="utf-8")
    assert "claspy/bin/pip install claspy" in page
    summary = tables.read(tables.METRICS, results / "experiments" / "summary.parquet")
    assert set(summary["model"]) == {"experiments"}
    for region in SERIES_REGIONS:
        rows = tables.read(tables.EXPERIMENTS, results / "experiments" / f"{region}.parquet")
        names = set(zip(rows["experiment"], rows["setting"], strict=True))
        assert {("reference", "configured"), ("clusters", "3"), ("beta", "40")} <= names
        own = summary[summary["metric"] == f"f1_{region}"]
        assert {f"{experiment}/{setting}" for experiment, setting in names} == set(own["variant"])
        assert own["value"].between(0, 1).all()
        assert f'<i class="line {region}">' in page
