"""The whole path on a tiny toy world: what comes out, and that no clip is lost on the way."""

import csv

import pandas as pd
import pytest

from mimeline import tables
from mimeline.annotation.fits import recall
from mimeline.annotation.fitted import read_fingerprint
from mimeline.annotation.label_file import read_label_file
from mimeline.inspection.funnel import funnel
from mimeline.inspection.why import why
from mimeline.vocabulary import SERIES_REGIONS

from .checkouts import CHECKOUT, TINY

STAGES = ("catalogue", "select", "fetch", "ingest", "pose", "split")


@pytest.fixture(scope="module")
def results(toy_run):
    return toy_run.root / "results"


@pytest.fixture(scope="module")
def ledger(results) -> pd.DataFrame:
    paths = [path for stage in STAGES for path in results.glob(f"{stage}/**/ledger.parquet")]
    return pd.concat(
        [tables.read(tables.LEDGER, path).assign(file=str(path)) for path in paths],
        ignore_index=True,
    )


def test_every_table_of_the_run_keeps_its_contract(results):
    kinds = {t.name: t for t in vars(tables).values() if isinstance(t, tables.Table)}
    kinds |= tables.COEFFICIENTS | {"generated": tables.MOTION, "log": tables.LOSSES}
    read = 0
    for path in results.rglob("*.parquet"):
        if path.stem in kinds:
            assert tables.read(kinds[path.stem], path) is not None
            read += 1
    assert read > 25


def test_clips_in_are_kept_dropped_or_failed_at_every_stage(results, ledger):
    came_in = None
    for stage in STAGES:
        rows = ledger.loc[ledger["stage"] == stage, ["clip_id", "status", "file"]]
        rows = rows.drop_duplicates()  # several notes, one decision in one shard
        assert rows["clip_id"].is_unique
        if came_in is not None:
            assert set(rows["clip_id"]) == came_in
        came_in = set(rows.loc[rows["status"] == "kept", "clip_id"])
    split = tables.read(tables.SPLIT, results / "split" / "split.parquet")
    assert set(split["clip_id"]) == came_in


def test_every_planted_fault_lands_where_it_should(results, ledger):
    with open(results / "toy" / "truth" / "faults.csv", newline="") as file:
        faults = list(csv.DictReader(file))
    assert len(faults) >= 12
    for fault in faults:
        rows = ledger[ledger["clip_id"] == fault["clip_id"]]
        last = rows.set_index("stage").loc[[s for s in STAGES if s in set(rows["stage"])]].iloc[-1]
        if fault["status"] == "kept":
            assert last["status"] == "kept", fault
        else:
            assert (last.name, last["status"]) == (fault["stage"], fault["status"]), fault
    lost = set(ledger.loc[ledger["status"] != "kept", "clip_id"])
    assert lost == {fault["clip_id"] for fault in faults if fault["status"] != "kept"}


def test_the_funnel_tells_what_the_ledgers_hold_and_every_clip_has_its_why(results, ledger):
    found = funnel(results, [], [])
    assert (found.problem, found.waiting) == ("", [])
    for stage in found.funnel.stages:
        rows = ledger[ledger["stage"] == stage.name].drop_duplicates("clip_id")
        told = {status: getattr(stage, status) for status in ("kept", "dropped", "failed")}
        assert told == {s: int((rows["status"] == s).sum()) for s in told}
    ids = list(ledger["clip_id"].unique())
    stories = {story.clip_id: story for story in why(results, ids).stories}
    assert set(stories) == set(ids)
    lost = ledger[ledger["status"] != "kept"]
    for row in lost.itertuples():
        last = stories[row.clip_id].decisions[-1]
        assert (last.stage, last.status, last.rule) == (row.stage, row.status, row.rule)
        assert stories[row.clip_id].todo
    assert sum(not story.todo for story in stories.values()) == found.funnel.kept


def test_a_what_if_runs_nothing_and_tells_what_a_wider_limit_keeps(results):
    before = {path: path.stat().st_mtime_ns for path in results.rglob("*")}
    found = funnel(results, [CHECKOUT / TINY], ["select.max_s=60"])
    (change,) = found.changes
    now = found.now["select"]
    assert found.differ["select"] == []
    long = now.reasons["too_long"]
    assert long > 0 and "too_long" not in change.reasons
    assert len(change.gained) == change.kept - now.kept == long
    assert {path: path.stat().st_mtime_ns for path in results.rglob("*")} == before


def test_kept_clips_are_described_counted_and_weighted(results):
    clips = tables.read_all(tables.CLIPS, results.glob("pose/*/clips.parquet"))
    descriptions = tables.read(tables.DESCRIPTIONS, results / "describe" / "descriptions.parquet")
    assert set(descriptions["clip_id"]) <= set(clips["clip_id"])
    assert {"catalogue", "timeline"} == set(descriptions["source"])
    assert descriptions.groupby(["clip_id", "source"]).size().eq(3).all()
    attributes = tables.read(tables.ATTRIBUTES, results / "describe" / "attributes.parquet")
    talking = clips["actions"].map(lambda actions: any(a["name"] == "talk" for a in actions))
    talk = attributes.set_index(["kind", "attribute"]).loc[("action", "talk")]
    assert (talk["clips"], talk["share"]) == (talking.sum(), pytest.approx(talking.mean()))
    weights = tables.read(tables.WEIGHTS, results / "describe" / "weights.parquet")
    assert set(weights["clip_id"]) == set(clips["clip_id"])
    assert weights["weight"].mean() == pytest.approx(1)


def test_no_near_duplicate_lies_on_two_sides(results):
    pairs = tables.read(tables.DUPLICATES, results / "split" / "duplicates.parquet")
    split = tables.read(tables.SPLIT, results / "split" / "split.parquet")
    part = split.set_index("clip_id")["part"]
    both = pairs[pairs["clip_id"].isin(part.index) & pairs["other_id"].isin(part.index)]
    assert (both["clip_id"].map(part) == both["other_id"].map(part)).all()
    filmed = tables.read_all(tables.CLIPS, results.glob("fetch/*/clips.parquet"))
    seen = tables.read_all(tables.FINGERPRINTS, results.glob("fetch/*/fingerprints.parquet"))
    assert set(seen["clip_id"]) == set(filmed.loc[filmed["media"].notna(), "clip_id"])


def test_every_frame_of_every_kept_clip_is_annotated(results):
    clips = tables.read_all(tables.CLIPS, results.glob("pose/*/clips.parquet"))
    frames = tables.read_all(tables.FRAMES, results.glob("annotate/*/frames.parquet"))
    counts = frames.groupby("clip_id").size()
    assert counts.to_dict() == clips.set_index("clip_id")["n_frames"].astype(int).to_dict()


def test_every_cluster_has_its_facts_its_exemplars_and_a_row_of_labels(results):
    label = results / "label"
    facts = tables.read(tables.PROFILES, label / "profiles.parquet")
    shown = tables.read(tables.EXEMPLARS, label / "exemplars.parquet")
    labels = tables.read(tables.LABELS, label / "labels.parquet")
    clusters = {
        (region, int(number))
        for region in SERIES_REGIONS
        for number in tables.read(
            tables.CLUSTERS, results / "segment" / region / "clusters.parquet"
        )["cluster"].unique()
    }
    for table in (facts, shown, labels):
        assert set(zip(table["region"], table["cluster"], strict=True)) == clusters
    ranks = shown.groupby(["region", "cluster"])["rank"].agg(list)
    assert all(sorted(rank) == list(range(len(rank))) for rank in ranks)


def test_the_names_of_a_run_are_a_label_file_of_its_fits_to_start_from(results):
    named = read_label_file(results / "label" / "labels.yaml")
    labels = tables.read(tables.LABELS, results / "label" / "labels.parquet")
    for region in SERIES_REGIONS:
        rows = labels[labels["region"] == region]
        assert set(named[region].clusters) == set(rows["cluster"])
        assert named[region].model == read_fingerprint(results / "segment" / region / "model")
        segments = recall(results / "label" / "fits", region, named[region].model)
        assert set(segments["cluster"]) == set(rows["cluster"])


def test_the_annotation_is_scored_for_every_region_and_variant(results):
    metrics = tables.read(tables.METRICS, results / "evaluate" / "annotation" / "metrics.parquet")
    table = metrics.pivot(index="variant", columns="metric", values="value")
    assert set(table.index) == {"named", "oracle", "gmm", "thresholds"}
    regions = ("brow", "eye", "closure", "mouth", "gaze", "head")
    of_frames = [f"f1_{region}" for region in regions]
    of_intervals = [f"segment_f1_{region}" for region in regions]
    of_edges = [f"boundary_mean_{region}" for region in regions]
    assert table.loc["named", of_frames + of_intervals].between(0, 1).all()
    assert (table.loc["named", of_edges] >= 0).all()
    assert (table.loc["oracle", of_frames] >= table.loc["named", of_frames] - 0.02).all()


def test_what_labels_are_worth_is_told_from_none_to_all_that_may_be_spent(results):
    metrics = tables.read(tables.METRICS, results / "evaluate" / "labelling" / "metrics.parquet")
    f1 = metrics[metrics["metric"] == "f1"]
    assert {"active", "random", "proposed", "person", "oracle"} <= set(f1["variant"])
    curve = f1[f1["variant"] == "active_unproposed"].sort_values("n")
    assert curve["n"].iloc[0] == 0
    assert curve["value"].iloc[-1] > curve["value"].iloc[0]
    assert f1["value"].between(0, 1).all()


def test_the_model_is_scored_with_and_without_its_timeline(results):
    metrics = tables.read(tables.METRICS, results / "evaluate" / "timeline" / "metrics.parquet")
    tas = metrics[metrics["metric"] == "tas"].set_index("variant")["value"]
    assert {"empty"} < set(tas.index)
    assert tas.between(0, 1).all()


def test_the_report_is_one_page_that_needs_no_network(results):
    page = (results / "report" / "index.html").read_text(encoding="utf-8")
    assert "mimeline on the toy world" in page
    assert "What the clips show" in page
    assert 'src="http' not in page
    assert 'href="http' not in page


def test_the_same_seed_gives_the_same_tables_on_one_core(toy_run, results):
    clusters = results / "segment" / "brow" / "clusters.parquet"
    before = clusters.read_bytes()
    target = str(clusters.relative_to(toy_run.root))
    done = toy_run.run(target, "--forcerun", "segment", "--cores", "1")
    assert done.returncode == 0, done.stderr
    assert clusters.read_bytes() == before
    assert "the report is" not in done.stdout + done.stderr  # that of an earlier run


def test_a_run_leaves_no_temporary_file(results):
    assert [p for p in results.rglob("*") if p.name.endswith((".tmp", ".making"))] == []
