import logging

import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.config.sections import TimelineModel
from mimeline.evaluation.coupling import FOLLOWS, LAG
from mimeline.evaluation.requests import as_frames, conflict
from mimeline.evaluation.variants import ASKED, CONFLICT, EYES, MADE, OURS, UNSEEN, variants
from mimeline.reporting.ablation_claims import DIVIDED, claims, judged
from mimeline.reporting.ablation_pictures import telling
from mimeline.reporting.ablation_scores import Study
from mimeline.reporting.ablations import ablations
from mimeline.reporting.claims import HARDLY, OTHER, SAME, TIE
from mimeline.reporting.published import published
from mimeline.vocabulary import ACTIONS, resource

from ..glances import followed, glances

CONFIGURED = TimelineModel().model_dump()
WANTED = ["no-branch", "no-base"]
CLIPS = {UNSEEN: 24, CONFLICT: 3}


def asked(name, rng) -> pd.DataFrame:
    drawn = [conflict(160, rng) if name == CONFLICT else glances(rng) for _ in range(CLIPS[name])]
    return as_frames(name, drawn, set(ACTIONS))


def trembling(frames, rng, law=0.15) -> pd.DataFrame:
    motion = followed(frames, law, rng)
    heads = [head for _, head, _ in FOLLOWS.values()]
    motion[heads] += rng.normal(0, 0.003, (len(frames), len(heads)))
    return motion


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Files of the tables by name; of what was asked, made and found by set, seed and variant."""
    folder, rng = tmp_path_factory.mktemp("runs"), np.random.default_rng(3)

    def written(table, rows, name, reason=""):
        tables.write(table, rows, folder / name, reason)
        return folder / name

    told = {name: asked(name, rng) for name in ASKED}
    made, found = {}, {}
    for variant in variants(CONFIGURED, WANTED):
        law = 0.0 if variant == "no-base" else 0.15
        lost = 0.5 if variant == "no-branch" else 0.02
        for name in MADE:
            frames, key = told.get(name, told[UNSEEN]), (variant, 0, name)
            seen = frames.assign(BrowUp=frames["BrowUp"] & (rng.random(len(frames)) > lost))
            own = trembling(frames, np.random.default_rng(4), 0)
            for gaze, head, _ in FOLLOWS.values():
                own[gaze] *= EYES.get(name, 1.0)
                own[head] += law * np.roll(own[gaze], LAG)
            made[key] = written(tables.MOTION, own, f"{variant}-{name}")
            if name in ASKED:
                found[key] = written(tables.FRAMES, seen, f"{variant}-{name}-found")
    others = as_frames("other", [glances(rng)] * 20, set(ACTIONS))
    real = pd.concat([told[UNSEEN], others], ignore_index=True)
    ids = sorted(real["clip_id"].unique())
    parts = ["train" if name.startswith("other") else "test" for name in ids]
    split = pd.DataFrame({"clip_id": ids, "part": parts, "group": ids})
    return {
        "asked": {name: written(tables.FRAMES, own, name) for name, own in told.items()},
        "made": made,
        "found": found,
        "motions": [written(tables.MOTION, trembling(real, rng), "motion")],
        "frames": [written(tables.FRAMES, real, "frames")],
        "clips": [written(tables.CLIPS, tables.empty(tables.CLIPS), "clips")],
        "split": written(tables.SPLIT, split, "split"),
    }


@pytest.fixture
def page(runs, tmp_path, caplog):
    def page(absent=()):
        files, why = dict(runs), "not measured: <gaze>"
        for kind, table in (
            ("asked", tables.FRAMES), ("made", tables.MOTION), ("found", tables.FRAMES)
        ):  # fmt: skip
            tables.write(table, tables.empty(table), tmp_path / kind, why)
            files[kind] = {
                key: tmp_path / kind if {key, key[-1]} & set(absent) else path
                for key, path in runs[kind].items()
            }
        with caplog.at_level(logging.INFO):
            ablations(
                **files,
                paper=resource("paper_ablations.csv"),
                page=tmp_path / "index.html",
                summary=tmp_path / "summary.parquet",
                configured=CONFIGURED,
                wanted=WANTED,
                side="left",
                unseen=24,
                choice_seed=0,
                resamples=8,
                seed=0,
                address="out/index.html",
            )
        html = (tmp_path / "index.html").read_text(encoding="utf-8")
        return html, tables.read(tables.METRICS, tmp_path / "summary.parquet")

    return page


def test_the_table_stands_beside_the_papers_and_is_told_in_the_terminal(page, caplog):
    html, summary = page()
    for title in ("Ours", "w/o branch", "w/o base", "real clips"):
        assert f'<th scope="row">{title}' in html
    for value in ("paper 0.840", "paper 0.660", "paper 0.810", "paper 0.0073", "paper 1.258"):
        assert value in html
    assert html.count("<svg") == 1 + 2 + 2  # dots, two panels, two clouds
    assert "http" not in html
    said = [record.message for record in caplog.records]
    assert any(line.startswith("w/o branch") for line in said)
    assert "the page is out/index.html" in said
    own = summary.set_index(["variant", "metric"])["value"]
    assert own["ours", "conflict"] > 0.95
    assert own["no-branch", "difference_conflict"] == pytest.approx(
        own["no-branch", "conflict"] - own["ours", "conflict"]
    )
    assert own["ours", "drift"] == pytest.approx(0.15)
    assert own["no-base", "drift"] == pytest.approx(0)
    assert own["real", "drift"] == pytest.approx(0.15, abs=0.05)
    assert "difference_tas" not in own["real"]
    rows = {row.split("<small>")[0].split(">")[-1].strip(): row for row in html.split("<tr>")}
    assert f">{SAME}<" in rows["So it is where actions conflict"]
    assert f">{SAME}<" in rows["Without a base the head no longer goes with the eyes"]


def test_what_was_not_measured_is_left_out_with_its_reason(page):
    html, summary = page(absent=[CONFLICT])
    assert "No conflicts: not measured: &lt;gaze&gt;." in html
    assert "TAS ↑, conflicts" not in html
    assert "conflict" not in set(summary["metric"])


def test_without_a_model_the_page_stands_and_says_why(page):
    html, summary = page(absent=MADE)
    assert "No score: not measured: &lt;gaze&gt;." in html
    assert "<svg" not in html
    assert "the paper?" not in html
    assert set(summary["variant"]) <= {"real"}


def scores(**each) -> Study:
    """each: of a variant, its tas in either training, all resamples alike but for a little."""
    noise = np.r_[0, np.random.default_rng(0).normal(0, 0.004, 200)]
    study = {}
    for n, (name, own) in enumerate(each.items(), start=1):
        draws = {seed: {"tas": value + n * noise} for seed, value in enumerate(own)}
        study[name.replace("_", "-")] = draws
    return Study(study)


@pytest.mark.parametrize(
    "other, words",
    [
        ((0.80, 0.82), SAME),
        ((0.99, 0.98), OTHER),
        ((0.90, 0.90), TIE),
        ((0.98, 0.70), DIVIDED),
    ],
)
def test_a_claim_holds_where_the_interval_and_all_seeds_say_so(other, words):
    study = scores(ours=(0.9, 0.9), no_branch=other)
    rows = variants(CONFIGURED, ["no-branch"])
    (said,) = judged(study, rows, CONFIGURED["branch_layers"], published())
    assert said.verdict.words == words
    assert said.paper == pytest.approx(0.18)


def test_a_difference_without_an_interval_is_a_tie():
    study = Study({OURS: {0: {"tas": np.array([0.9])}}, "no-branch": {0: {"tas": np.array([0.5])}}})
    (said,) = judged(study, variants(CONFIGURED, ["no-branch"]), 1, {})
    assert said.verdict.words == TIE


def test_a_sure_but_small_difference_is_hardly_one():
    noise = np.r_[0, np.random.default_rng(0).normal(0, 0.0005, 100)]
    study = Study({OURS: {0: {"tas": 0.9 + 0 * noise}}, "no-branch": {0: {"tas": 0.895 + noise}}})
    (said,) = judged(study, variants(CONFIGURED, ["no-branch"]), 1, {})
    assert said.verdict.words == HARDLY
    assert said.paper is None


def test_more_branch_layers_are_those_beyond_the_configured():
    def deepest(base, branch):
        keys = TimelineModel(base_layers=base, branch_layers=branch).model_dump()
        found = claims(variants(keys, ["depth"]), branch)
        return [claim.more for claim in found if claim.metric == "snd"]

    assert deepest(6, 2) == ["branch-layers-7"]
    assert deepest(1, 2) == []


def test_the_timeline_that_is_shown_is_the_one_of_the_median_difference():
    on = np.zeros((20, len(ACTIONS)), bool)
    on[:, list(ACTIONS).index("BrowUp")] = True
    told = as_frames("conflict", [on] * 5, set(ACTIONS))
    lost = {"conflict-000": 2, "conflict-001": 9, "conflict-002": 4, "conflict-003": 20,
            "conflict-004": 0}  # fmt: skip
    second = told.assign(BrowUp=told["frame"] >= told["clip_id"].map(lost))
    assert telling(told, told, second) == "conflict-002"
