import logging

import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.reporting.panels import TOP, Point, favourite, grid, panels
from mimeline.reporting.sweep import summary, sweep

COUNTS, BETAS = (3, 5, 9), (5.0, 20.0, 80.0)


def scores(region: str, truth: bool = True, seeds: int = 2) -> pd.DataFrame:
    """5 clusters with beta 20 have the best f1, 3 with beta 20 the best BIC."""
    keys = [(k, beta, seed) for k in COUNTS for beta in BETAS for seed in range(seeds)]
    rows = pd.DataFrame(keys, columns=["n_clusters", "beta", "seed"])
    off = (rows["n_clusters"] - 5).abs() / 20 + (rows["beta"] - 20).abs() / 100
    return rows.assign(
        region=region,
        objective=0.0,
        bic=5e4 + 100 * rows["n_clusters"] + (rows["beta"] - 20).abs() + rows["seed"],
        n_switches=40,
        mean_frames=2 * rows["beta"],
        used=rows["n_clusters"],
        stability=1 - rows["n_clusters"] / 40 if seeds > 1 else np.nan,
        f1=0.95 - off - 0.01 * rows["seed"] if truth else np.nan,
    )


@pytest.fixture
def page(tmp_path, caplog):
    def page(**regions):
        paths = {}
        for region, (rows, reason) in regions.items():
            paths[region] = tmp_path / f"{region}.parquet"
            tables.write(tables.SWEEP, rows, paths[region], reason)
        count = len(paths)
        with caplog.at_level(logging.INFO):
            sweep(tmp_path / "page.html", paths, [9] * count, [20.0] * count, "out/index.html")
        return (tmp_path / "page.html").read_text(encoding="utf-8")

    return page


def test_the_page_says_what_each_score_favours_and_how_to_set_it(page, caplog):
    html = page(brow=(scores("brow"), ""), eye=(scores("eye"), ""))
    assert "Against the truth, 5 clusters with beta 20 do best: macro-F1 0.945" in html
    assert "BIC favours 3 clusters with beta 20, where macro-F1 is 0.845" in html
    assert "  brow: {n_clusters: 5, beta: 20}\n  eye: {n_clusters: 5, beta: 20}" in html
    assert "segment={brow: {n_clusters: 3, beta: 20}, eye: {n_clusters: 3, beta: 20}}" in html
    assert "the page is out/index.html" in caplog.text
    assert html.count("<svg") == 6
    assert html.count('<table class="map') == 6
    assert "http" not in html


def test_a_favourite_at_the_edge_of_the_grid_is_said_to_be_there(page):
    html = page(brow=(scores("brow"), ""))
    assert "That is the edge of the grid: it may lie beyond sweep.n_clusters." in html
    inside = scores("brow").assign(bic=lambda t: (t["n_clusters"] - 5.0).abs() + t["beta"])
    html = page(brow=(inside[inside["beta"] > 5], ""))
    assert "it may lie beyond sweep.beta." in html
    inside["bic"] += 1000.0 * (inside["beta"] == 5)
    assert "edge of the grid" not in page(brow=(inside, ""))


def test_more_clusters_configured_than_the_frames_can_tell_is_said(page):
    rows = scores("brow")
    html = page(brow=(rows[rows["n_clusters"] < 9], ""))
    assert "The frames are too few for 9 clusters, as configured: 5 stand for it here." in html
    assert "Different starts agree (0.93) there; as configured they disagree (0.88)." in html


def test_without_truth_and_seeds_bic_speaks_alone(page):
    html = page(brow=(scores("brow", truth=False, seeds=1), ""))
    assert "macro-F1" not in html
    assert "tability" not in html
    assert "BIC favours 3 clusters with beta 20." in html
    assert html.count("<svg") == 2


def test_a_region_without_a_sweep_is_named_with_its_reason(page):
    none = tables.empty(tables.SWEEP)
    html = page(brow=(scores("brow"), ""), eye=(none, "not measured: <eye>"))
    assert "Not swept: not measured: &lt;eye&gt;." in html
    assert "eye: {n_clusters" not in html
    html = page(eye=(none, "no clip came through"))
    assert "nothing to choose" in html
    assert "<svg" not in html


def test_of_equal_points_the_one_with_fewest_clusters_is_favoured():
    rows = scores("brow").assign(f1=0.9, stability=1.0)
    points = summary(rows)
    assert favourite(points, "f1") == Point(3, 5.0)
    assert favourite(points, "bic") == Point(3, 20.0)


def test_of_points_that_starts_could_exchange_the_stablest_is_favoured():
    rows = scores("brow").assign(bic=lambda t: 100 * t["seed"] + (t["beta"] - 20).abs())
    rows["stability"] = rows["n_clusters"].map({3: 0.7, 5: 0.9, 9: 0.8})
    assert favourite(summary(rows), "bic") == Point(5, 5.0)
    rows["bic"] += 1000.0 * (rows["beta"] == 5)
    assert favourite(summary(rows), "bic") == Point(5, 20.0)


def test_curves_run_through_the_configured_point_and_mark_the_best():
    configured = {"brow": Point(9, 20.0)}
    along_k, along_beta = panels({"brow": summary(scores("brow"))}, "bic", "BIC", configured)
    assert [text for _, text in along_k.x_ticks] == ["3", "5", "9"]
    assert [text for _, text in along_beta.x_ticks] == ["5", "20", "80"]
    first, middle, last = (x for x, _ in along_beta.x_ticks)
    assert last - middle == pytest.approx(middle - first, abs=0.2)  # logarithmic
    kinds = [mark.kind for mark in along_k.traces[0].marks]
    assert kinds == ["best", "", "configured"]
    assert [mark.kind for mark in along_beta.traces[0].marks] == ["", "best configured", ""]


def test_the_map_holds_every_point_and_is_strongest_at_the_best():
    found = grid(summary(scores("brow")), "f1", "macro-F1", Point(9, 20.0))
    assert found.counts == [3, 5, 9]
    assert [beta for beta, _ in found.rows] == ["80", "20", "5"]
    cells = {(beta, n): c for beta, row in found.rows for n, c in zip(COUNTS, row, strict=True)}
    assert cells["20", 5].favoured
    assert cells["20", 5].shade == 1
    assert min(c.shade for c in cells.values()) == 0
    assert [key for key, cell in cells.items() if cell.configured] == [("20", 9)]


def test_a_beta_of_zero_stands_one_step_left_of_the_least_positive_one(page):
    rows = scores("brow").assign(
        beta=lambda t: t["beta"].replace({5.0: 0.0, 20.0: 5.0, 80.0: 20.0})
    )
    assert 'cx="nan"' not in page(brow=(rows, ""))
    _, along_beta = panels({"brow": summary(rows)}, "bic", "BIC", {"brow": Point(9, 20.0)})
    assert [text for _, text in along_beta.x_ticks] == ["0", "5", "20"]
    zero, five, twenty = (x for x, _ in along_beta.x_ticks)
    assert five - zero == pytest.approx(twenty - five, abs=0.2)
    assert [mark.x for mark in along_beta.traces[0].marks] == [zero, five, twenty]
    two = summary(rows[rows["beta"] < 20])
    _, along_beta = panels({"brow": two}, "bic", "BIC", {"brow": Point(9, 5.0)})
    (zero, _), (five, _) = along_beta.x_ticks
    assert zero < five


@pytest.mark.parametrize("score", ["f1", "stability"])
def test_perfect_scores_lie_at_the_top(score):
    points = {"brow": summary(scores("brow").assign(f1=1.0, stability=1.0))}
    for panel in panels(points, score, score, {"brow": Point(9, 20.0)}):
        assert {mark.y for mark in panel.traces[0].marks} == {TOP}
        ys = [y for y, _ in panel.y_ticks]
        assert min(ys) == TOP
        assert max(ys) > TOP
