import logging

import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.annotation.scores import macro_f1
from mimeline.evaluation.attempts import REFERENCE
from mimeline.reporting.claims import HARDLY, OTHER, SAME, TIE, claims, verdicts
from mimeline.reporting.experiments import experiments
from mimeline.reporting.paired import Compared
from mimeline.vocabulary import NEUTRAL, resource, series_actions

CONFIGURED = {"n_clusters": 9, "beta": 20.0, "boundary": "mask"}
SETTINGS = {  # → share of the frames that are wrong
    REFERENCE: 0.02,
    ("clusters", "3"): 0.10,
    ("clusters", "12"): 0.03,
    ("beta", "5"): 0.05,
    ("beta", "80"): 0.30,
    ("separators", "null sequences"): 0.09,
    ("separators", "one sequence"): 0.05,
    ("descriptors", "action units"): 0.20,
    ("sides", "both sides"): 0.02,
    ("unseen", "unseen"): 0.03,
    ("baselines", "thresholds"): 0.15,
    ("baselines", "Gaussian HMM"): 0.04,
}
CLIPS, FRAMES = 24, 100


def judged(region, settings=None, seeds=(0, 1), clips=CLIPS) -> pd.DataFrame:
    """Frames by class; a setting's share of them, by chance in which clips, is called Neutral."""
    rng = np.random.default_rng(5)
    hard = rng.gamma(2.0, 0.5, size=clips)  # clips are hard for every setting alike
    rows = []
    for (experiment, setting), share in (settings or SETTINGS).items():
        for seed in seeds:
            for clip in range(clips):
                if experiment == "unseen" and clip % 2 != seed:
                    continue
                wrong = min(rng.binomial(FRAMES, min(share * hard[clip], 0.9)), FRAMES - 1)
                key = (region, experiment, setting, seed, f"clip_{clip}")
                for action in (NEUTRAL, *series_actions(region)):
                    lost = 0 if action == NEUTRAL else wrong
                    rows.append((*key, action, action, FRAMES - lost))
                    if lost:
                        rows.append((*key, action, NEUTRAL, lost))
    return pd.DataFrame(rows, columns=tables.EXPERIMENTS.schema.names)


@pytest.fixture
def page(tmp_path, caplog):
    def page(left_out=(), annotation=(), side="left", **regions):
        found, missing = {}, {}
        for region, (rows, reason) in regions.items():
            found[region] = tmp_path / f"{region}.parquet"
            missing[region] = tmp_path / f"{region}-left-out.parquet"
            tables.write(tables.EXPERIMENTS, rows, found[region], reason)
            own = [row for row in left_out if row[0] == region]
            table = pd.DataFrame(own, columns=tables.LEFT_OUT.schema.names)
            tables.write(tables.LEFT_OUT, table, missing[region])
        scores = pd.DataFrame(list(annotation), columns=tables.METRICS.schema.names)
        tables.write(tables.METRICS, scores, tmp_path / "metrics.parquet")
        with caplog.at_level(logging.INFO):
            experiments(
                found=found,
                left_out=missing,
                annotation=tmp_path / "metrics.parquet",
                paper=resource("paper_scores.csv"),
                page=tmp_path / "index.html",
                summary=tmp_path / "summary.parquet",
                configured=[CONFIGURED] * len(found),
                side=side,
                resamples=200,
                seed=3,
                address="out/index.html",
            )
        html = (tmp_path / "index.html").read_text(encoding="utf-8")
        return html, tables.read(tables.METRICS, tmp_path / "summary.parquet")

    return page


def test_the_page_shows_every_setting_beside_the_papers_numbers(page, caplog):
    limit = ("annotation", "named", "all", "f1_closure", 0.963, 0.954, 0.972, 900, 0)
    html, summary = page(brow=(judged("brow"), ""), mouth=(judged("mouth"), ""), annotation=[limit])
    for name in ("clips apart", "null sequences", "one sequence", "blendshapes", "action units",
                 "left side", "both sides", "fitted as well", "unseen", "TICC", "thresholds",
                 "Gaussian HMM"):  # fmt: skip
        assert f">{name}" in html
    for number in ("3", "9", "12", "5", "20", "80"):
        assert f'<th scope="row">{number}' in html
    for value in (
        "paper’s best 0.90",
        "paper’s best 0.87",
        "paper 0.73",
        "paper 0.89",
        "paper 0.85",
    ):
        assert value in html
    assert "<b>0.963</b> <small>0.954–0.972</small></td><td>paper 0.95</td>" in html
    assert "the page is out/index.html" in caplog.text
    variants = {f"{experiment}/{setting}" for experiment, setting in SETTINGS}
    assert set(summary["variant"]) == variants
    assert set(summary["metric"]) == {f"{kind}_{region}" for kind in ("f1", "difference")
                                      for region in ("brow", "mouth")}  # fmt: skip
    assert "http" not in html
    assert html.count("<svg") == 2 + 5


def test_what_was_left_out_says_why_and_how_to_have_it(page):
    missing = [
        ("brow", "baselines", "CLaP", "experiments.claspy names no <interpreter>"),
        ("brow", "clusters", "40", "the frames are too few"),
    ]
    html, _ = page(missing, brow=(judged("brow"), ""))
    assert "experiments.claspy names no &lt;interpreter&gt;" in html
    assert "claspy/bin/pip install claspy" in html
    assert "How many clusters: 40" in html
    assert "the frames are too few" in html


def test_regions_without_a_result_are_told_and_the_page_stands(page):
    none = tables.empty(tables.EXPERIMENTS)
    html, summary = page(brow=(judged("brow"), ""), eye=(none, "not measured: <eye>"))
    assert "Eye: nothing was tried: not measured: &lt;eye&gt;." in html
    assert not summary["metric"].str.contains("eye").any()
    html, summary = page(brow=(none, "no truth is known for these recordings"))
    assert "no truth is known" in html
    assert summary.empty
    assert "<svg" not in html


def test_a_score_is_the_mean_over_the_seeds_of_macro_f1():
    rows = judged("brow")
    own = Compared(rows, "brow", 300, 0)
    names = [NEUTRAL, *series_actions("brow")]
    values = []
    for _, each in rows[rows["setting"] == "configured"].groupby("seed"):
        counts = each.groupby(["truth", "found"])["frames"].sum().unstack(fill_value=0)
        values.append(
            float(macro_f1(counts.reindex(names, columns=names, fill_value=0).to_numpy()))
        )
    score = own.score(REFERENCE)
    assert score.value == pytest.approx(np.mean(values))
    assert (score.least, score.most) == pytest.approx((min(values), max(values)))
    assert score.low < score.value < score.high


def test_a_paired_interval_is_narrower_than_what_two_intervals_say():
    own = Compared(judged("brow", clips=60), "brow", 500, 0)
    key = ("beta", "5")
    gain, first, second = own.difference(key, REFERENCE), own.score(key), own.score(REFERENCE)
    assert gain.value == pytest.approx(first.value - second.value)
    apart = np.hypot(first.high - first.low, second.high - second.low)
    assert gain.high - gain.low < 0.9 * apart
    assert not gain.tie
    assert own.difference(REFERENCE, REFERENCE).tie


def test_unseen_clips_are_compared_with_the_same_clips_where_they_were_fitted():
    rows = judged("brow")
    own = Compared(rows, "brow", 100, 0)
    key = ("unseen", "unseen")
    same = own.score(REFERENCE, like=key)
    assert own.difference(key, REFERENCE).value == pytest.approx(own.score(key).value - same.value)
    assert same.value != own.score(REFERENCE).value


def test_a_verdict_follows_the_papers_order_and_the_interval():
    own = {"brow": Compared(judged("brow", clips=60), "brow", 400, 0)}
    said = {}
    for claim in claims(own, {"brow": CONFIGURED}):
        said[claim.text] = verdicts(claim, own)["brow"].words
    assert said["Too few clusters do worse"] == SAME
    assert said["Blendshapes do better than action units"] == SAME
    assert said["Null sequences do better than no separator"] == OTHER  # as made up above
    assert said["One side is enough"] == SAME
    assert len(said) == 9
    alike = {**SETTINGS, ("beta", "80"): SETTINGS[REFERENCE]}
    own = {"brow": Compared(judged("brow", alike, clips=60), "brow", 400, 0)}
    found = {c.text: verdicts(c, own)["brow"].words for c in claims(own, {"brow": CONFIGURED})}
    assert found["Too large a beta does worse"] in (TIE, HARDLY)


def test_a_sure_difference_that_is_tiny_is_no_support_for_the_paper():
    """All clips alike: no interval holds 0."""
    rows = [
        ("brow", *key, 0, f"clip_{clip}", action, found, frames)
        for key, wrong in ((REFERENCE, 20), (("clusters", "12"), 23), (("clusters", "3"), 90))
        for clip in range(5)
        for action in (NEUTRAL, *series_actions("brow"))
        for found, frames in ((action, 1000 - wrong), (NEUTRAL, wrong))
    ]
    table = pd.DataFrame(rows, columns=tables.EXPERIMENTS.schema.names)
    table = table.groupby(list(table.columns[:-1]), as_index=False)["frames"].sum()
    own = {"brow": Compared(table, "brow", 50, 0)}
    found = {c.text: verdicts(c, own)["brow"] for c in claims(own, {"brow": CONFIGURED})}
    assert not any(verdict.difference.tie for verdict in found.values())
    assert found["Too many clusters do worse"].words == HARDLY
    assert found["Too few clusters do worse"].words == SAME


def test_where_null_sequences_are_configured_they_are_what_the_paper_has():
    settings = {REFERENCE: 0.02, ("separators", "one sequence"): 0.2}
    own = {"brow": Compared(judged("brow", settings), "brow", 100, 0)}
    asked = claims(own, {"brow": CONFIGURED | {"boundary": "paper"}})
    assert [claim.text for claim in asked] == ["Null sequences do better than no separator"]
    assert verdicts(asked[0], own)["brow"].words == SAME
