"""The whole path on a tiny toy world: what comes out, and that no clip is lost on the way."""

import csv

import pandas as pd
import pytest

from mimeline import tables

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


def test_every_frame_of_every_kept_clip_is_annotated(results):
    clips = tables.read_all(tables.CLIPS, results.glob("pose/*/clips.parquet"))
    frames = tables.read_all(tables.FRAMES, results.glob("annotate/*/frames.parquet"))
    counts = frames.groupby("clip_id").size()
    assert counts.to_dict() == clips.set_index("clip_id")["n_frames"].astype(int).to_dict()


def test_the_annotation_is_scored_for_every_region_and_variant(results):
    metrics = tables.read(tables.METRICS, results / "evaluate" / "annotation" / "metrics.parquet")
    table = metrics.pivot(index="variant", columns="metric", values="value")
    assert set(table.index) == {"named", "oracle", "gmm"}
    regions = ("brow", "eye", "closure", "mouth", "gaze", "head")
    assert set(table.columns) == {f"f1_{region}" for region in regions}
    assert (table.loc["oracle"] >= table.loc["named"] - 0.02).all()


def test_the_model_is_scored_with_and_without_its_timeline(results):
    metrics = tables.read(tables.METRICS, results / "evaluate" / "timeline" / "metrics.parquet")
    tas = metrics[metrics["metric"] == "tas"].set_index("variant")["value"]
    assert {"empty"} < set(tas.index)
    assert tas.between(0, 1).all()


def test_the_report_is_one_page_that_needs_no_network(results):
    page = (results / "report" / "index.html").read_text(encoding="utf-8")
    assert "mimeline on the toy world" in page
    assert 'src="http' not in page
    assert 'href="http' not in page


def test_the_same_seed_gives_the_same_tables_on_one_core(toy_run, results):
    clusters = results / "segment" / "brow" / "clusters.parquet"
    before = clusters.read_bytes()
    done = toy_run.run("--forcerun", "segment", "--cores", "1", "--until", "segment")
    assert done.returncode == 0, done.stderr
    assert clusters.read_bytes() == before
    assert "the report is" not in done.stdout + done.stderr  # that of an earlier run


def test_a_run_leaves_no_temporary_file(results):
    assert [p for p in results.rglob("*") if p.name.endswith((".tmp", ".making"))] == []
