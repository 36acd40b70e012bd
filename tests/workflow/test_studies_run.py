"""Sweep, experiments and ablations on a finished run: no part of it, and none of it runs again."""

from mimeline import tables
from mimeline.vocabulary import SERIES_REGIONS


def test_they_fit_nothing_of_the_run_again(studied_run):
    _, said = studied_run
    # Three regions and a page of sweep and experiments; of the ablations the timelines asked for,
    # two models trained and asked, and a page.
    assert "14 of 14 steps" in said, said


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


def test_the_ablations_end_with_their_page(studied_run):
    results, said = studied_run
    assert "mimeline: the page is results/ablations/index.html" in said
    page = (results / "ablations" / "index.html").read_text(encoding="utf-8")
    assert "w/o branch" in page and "Ours" in page
    summary = tables.read(tables.METRICS, results / "ablations" / "summary.parquet")
    assert {"ours", "no-branch"} <= set(summary["variant"])
    for name in ("ours", "no-branch"):
        assert (results / "ablations" / name / "0" / "checkpoint" / "model.safetensors").exists()


def test_the_configured_variant_is_the_model_of_the_run(studied_run):
    results, _ = studied_run
    model = "checkpoint/model.safetensors"
    ours = results / "ablations" / "ours" / "0" / model
    assert ours.read_bytes() == (results / "train" / "timeline" / model).read_bytes()
