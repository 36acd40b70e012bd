from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.annotation.exemplars import exemplars
from mimeline.annotation.fits import recall
from mimeline.annotation.fitted import read_fingerprint
from mimeline.vocabulary import resource


@pytest.fixture(scope="module")
def run(segmented, tmp_path_factory):
    """Writes the stage's tables for regions of the segmented world and reads them."""

    def run(regions=("brow", "eye", "mouth"), seed=0):
        out = tmp_path_factory.mktemp("label")
        inputs = [{r: f[r] for r in regions} for f in vars(segmented).values() if type(f) is dict]
        series, clusters, models = inputs
        written = SimpleNamespace(
            proposed=out / "proposed.parquet",
            exemplars=out / "exemplars.parquet",
            profiles=out / "profiles.parquet",
        )
        exemplars(
            series,
            clusters,
            models,
            resource("proposals.csv"),
            **vars(written),
            side="left",
            n_random=2,
            n_further=3,
            seed=seed,
        )
        written.labels = tables.read(tables.LABELS, written.proposed)
        written.shown = tables.read(tables.EXEMPLARS, written.exemplars)
        written.facts = tables.read(tables.PROFILES, written.profiles)
        return written

    return run


@pytest.fixture(scope="module")
def written(run):
    return run()


def test_every_cluster_has_a_name_or_a_reason_facts_and_exemplars(written, segmented):
    keys = ["region", "cluster"]
    clusters = [tables.read(tables.CLUSTERS, segmented.clusters[r]) for r in ("brow", "eye")]
    known = {
        (r, k) for r, rows in zip(("brow", "eye"), clusters, strict=True) for k in rows["cluster"]
    }
    for table in (written.labels, written.facts, written.shown):
        assert set(map(tuple, table[keys].to_numpy())) == known
    assert (written.labels["action"].isna() == written.labels["why"].notna()).all()


def test_planted_actions_get_their_names(written):
    names = written.labels.groupby("region")["action"].agg(set)
    assert names["brow"] == {"Neutral", "BrowUp", "BrowDown"}
    assert names["eye"] == {"Neutral", "EyeSquint", "EyeWiden"}


def test_exemplars_are_runs_of_their_cluster(written, segmented):
    clusters = tables.read(tables.CLUSTERS, segmented.clusters["brow"])
    for row in written.shown[written.shown["region"] == "brow"].itertuples():
        frames = clusters[clusters["clip_id"] == row.clip_id]
        inside = frames["frame"].between(row.start_frame, row.end_frame - 1)
        assert inside.sum() == row.end_frame - row.start_frame
        assert set(frames.loc[inside, "cluster"]) == {row.cluster}


def test_a_regions_choice_stays_when_another_region_is_fitted_anew(run, written):
    alone = run(("brow",)).shown
    brow = written.shown[written.shown["region"] == "brow"].reset_index(drop=True)
    pd.testing.assert_frame_equal(alone, brow)


def test_the_seed_changes_the_random_ones(run, written):
    assert not run(seed=1).shown.equals(written.shown)


def test_each_fit_is_remembered_with_its_clusters(written, segmented):
    for region in ("brow", "eye"):
        fingerprint = read_fingerprint(segmented.models[region])
        segments = recall(written.exemplars.with_name("fits"), region, fingerprint)
        frames = (segments["end_frame"] - segments["start_frame"]).sum()
        assert frames == len(tables.read(tables.CLUSTERS, segmented.clusters[region]))


def test_where_no_region_was_segmented_the_tables_are_empty_and_say_why(run):
    written = run(("mouth",))
    for path in (written.proposed, written.exemplars, written.profiles):
        assert tables.reason(path) == "no region could be segmented"
    assert written.labels.empty and written.shown.empty and written.facts.empty


def test_shares_add_up_and_agree_with_the_facts(written):
    both = written.labels.merge(written.facts, on=["region", "cluster"])
    for _, rows in both.groupby("region"):
        assert np.allclose(rows["share"], rows["n_frames"] / rows["n_frames"].sum())
