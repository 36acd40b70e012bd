import shlex
from types import SimpleNamespace

import pandas as pd
import pytest
import yaml

from mimeline import tables
from mimeline.annotation.exemplars import exemplars
from mimeline.annotation.fits import recall
from mimeline.annotation.fitted import FINGERPRINT_FILE, read_fingerprint
from mimeline.annotation.label_file import Answer, RegionAnswers, kept_copy, read_label_file
from mimeline.annotation.labels import label, settle
from mimeline.cli import _parsed
from mimeline.errors import BadLabels
from mimeline.vocabulary import resource

REGIONS = ("brow", "eye", "mouth")


@pytest.fixture(scope="module")
def proposals(segmented, tmp_path_factory):
    """Results of the stage before: proposals, and the fits remembered."""
    results = tmp_path_factory.mktemp("results of a take")
    out = results / "label"
    written = [out / f"{name}.parquet" for name in ("proposed", "exemplars", "profiles")]
    inputs = (segmented.series, segmented.clusters, segmented.models, resource("proposals.csv"))
    exemplars(*inputs, *written, side="left", n_random=2, n_further=3, seed=0)
    return results


@pytest.fixture(scope="module")
def fingerprint(segmented):
    return {region: read_fingerprint(segmented.models[region]) for region in ("brow", "eye")}


@pytest.fixture
def run(proposals, segmented, tmp_path):
    """label with a person's file, given as text or as what YAML holds."""

    def run(given=None, world=segmented, results=proposals, min_agreement=0.8):
        file = None
        if given is not None:
            file = str(tmp_path / "mine.yaml")
            text = given if isinstance(given, str) else yaml.safe_dump(given)
            (tmp_path / "mine.yaml").write_text(text)
        out = tmp_path / "labels.parquet", tmp_path / "labels.yaml"
        proposed = results / "label" / "proposed.parquet"
        label(proposed, world.clusters, world.models, *out, file, min_agreement)
        return tables.read(tables.LABELS, out[0]).set_index(["region", "cluster"])

    run.names = tmp_path / "labels.yaml"
    run.file = tmp_path / "mine.yaml"
    return run


@pytest.fixture
def refitted(segmented, proposals, tmp_path):
    """The world after a refit: the brow's clusters by another map, with another fingerprint."""

    def refitted(change):
        rows = tables.read(tables.CLUSTERS, segmented.clusters["brow"])
        rows["cluster"] = change(rows)
        world = SimpleNamespace(
            clusters=segmented.clusters | {"brow": tmp_path / "clusters.parquet"},
            models=segmented.models | {"brow": tmp_path / "model"},
        )
        tables.write(tables.CLUSTERS, rows, world.clusters["brow"])
        world.models["brow"].mkdir()
        for path in segmented.models["brow"].iterdir():
            (world.models["brow"] / path.name).write_bytes(path.read_bytes())
        (world.models["brow"] / FINGERPRINT_FILE).write_text("anew")
        return world

    return refitted


def turned(rows):
    return (rows["cluster"] + 1) % 3


def merged(rows):
    return rows["cluster"].where(rows["cluster"] != 1, 0)


def block(fingerprint, clusters, region="brow"):
    return {region: {"model": fingerprint[region], "clusters": clusters}}


def other(labels, region, cluster):
    """An action of the brow that was not proposed for a cluster."""
    return "BrowDown" if labels.loc[(region, cluster), "action"] == "BrowUp" else "BrowUp"


def test_without_a_file_each_cluster_has_its_proposal(run):
    labels = run()
    assert set(labels.index.get_level_values("region")) == {"brow", "eye"}
    assert set(labels["source"]) == {"proposed"}


def test_a_persons_name_overrides_and_clusters_without_one_keep_the_proposal(run, fingerprint):
    proposed = run()
    name = other(proposed, "brow", 1)
    labels = run(block(fingerprint, {1: name}))
    row = labels.loc[("brow", 1)]
    assert row[["action", "source"]].tolist() == [name, "human"]
    assert pd.isna(row["confidence"])
    rest = labels.index != ("brow", 1)
    pd.testing.assert_frame_equal(labels[rest], proposed[rest])


def test_notes_are_kept_even_where_they_look_like_numbers(run, fingerprint):
    entries = {
        0: {"action": "BrowUp", "note": "strong"},
        1: {"action": "BrowUp", "note": 3},
        2: {"action": "Neutral"},
    }
    labels = run(block(fingerprint, entries))
    assert labels.loc["brow", "action"].tolist() == ["BrowUp", "BrowUp", "Neutral"]
    assert labels.loc["brow", "note"].fillna("-").tolist() == ["strong", "3", "-"]


def test_not_sure_leaves_the_frames_without_an_action(run, fingerprint):
    row = run(block(fingerprint, {0: "not sure"})).loc[("brow", 0)]
    assert pd.isna(row["action"])
    assert row[["source", "why"]].tolist() == ["human", "not sure"]


def test_a_merged_cluster_has_the_name_of_the_other(run, fingerprint):
    named = {0: {"same_as": 1}, 1: {"same_as": 2}, 2: {"action": "BrowDown", "note": "weak"}}
    labels = run(block(fingerprint, named)).loc["brow"]
    assert labels["action"].tolist() == ["BrowDown"] * 3
    assert labels["note"].tolist() == ["weak"] * 3


def test_a_cluster_merged_into_one_that_nobody_named_has_its_proposal(run, fingerprint):
    proposed = run()
    labels = run(block(fingerprint, {0: {"same_as": 1}}))
    columns = ["action", "source", "confidence"]
    assert labels.loc[("brow", 0), columns].tolist() == proposed.loc[("brow", 1), columns].tolist()


def test_the_names_of_a_run_are_a_label_file_that_gives_them_again(run, fingerprint):
    given = {0: {"action": "BrowUp", "note": "trembling: a lot"}, 1: {"same_as": 0}, 2: "not sure"}
    labels, names = run(block(fingerprint, given)), run.names.read_text()
    again = run(names)
    columns = ["action", "note"]
    pd.testing.assert_frame_equal(again[columns], labels[columns])
    assert run.names.read_text() == names
    assert names.startswith("# The clusters' names as they hold in this run, proposals among them")


@pytest.mark.parametrize("name", ["Browup", "Smile", "EyeClose"])
def test_an_action_that_the_region_does_not_have_is_refused(run, fingerprint, name):
    with pytest.raises(BadLabels, match="cluster 2: .*expected one of BrowUp, BrowDown, Neutral"):
        run(block(fingerprint, {2: name}))


@pytest.mark.parametrize("entry", [{7: "BrowUp"}, {0: {"same_as": 7}}])
def test_a_cluster_that_does_not_exist_is_refused(run, fingerprint, entry):
    with pytest.raises(BadLabels, match="no such cluster.* expected one of 0, 1, 2"):
        run(block(fingerprint, entry))


@pytest.mark.parametrize("region", ["nose", "7"])
def test_a_region_that_does_not_exist_is_refused(run, fingerprint, region):
    given = block(fingerprint, {0: "BrowUp"}) | {region: {"model": "x", "clusters": {}}}
    with pytest.raises(BadLabels, match=f"'{region}', expected one of brow, eye, mouth"):
        run(given)


def test_an_empty_label_file_names_nothing(run):
    assert set(run("# nothing yet\n")["source"]) == {"proposed"}


def test_names_of_a_region_that_was_not_segmented_are_told(run, caplog):
    labels = run({"mouth": {"model": "x", "clusters": {0: "Smile"}}})
    assert "mouth" not in labels.index.get_level_values("region")
    assert "mouth is not segmented, so its names" in caplog.text


def test_after_a_refit_names_move_with_their_frames(run, refitted, fingerprint, caplog):
    caplog.set_level("INFO")
    strong = {"action": "BrowUp", "note": "strong"}
    given = block(fingerprint, {0: strong, 1: "BrowDown"})
    before, after = run(given), run(given, refitted(turned))
    assert after.loc[("brow", 1), ["action", "note", "source"]].tolist() == [
        "BrowUp",
        "strong",
        "moved",
    ]
    assert after.loc[("brow", 2), ["action", "source"]].tolist() == ["BrowDown", "moved"]
    assert after.loc[("brow", 1), "confidence"] == 1
    assert after.loc[("brow", 0), "source"] == "proposed"
    pd.testing.assert_frame_equal(before.loc[["eye"]], after.loc[["eye"]])
    assert f"brow: names moved from fit {fingerprint['brow']}: 100 % of 720 frames" in caplog.text
    assert caplog.text.count("brow: 2 of 3 clusters named by a person") == 2


def test_the_names_of_a_run_after_a_refit_are_names_of_the_present_fit(run, refitted, fingerprint):
    run(block(fingerprint, {0: "BrowUp", 1: "BrowDown"}), refitted(turned))
    assert read_label_file(run.names)["brow"].model == "anew"


def test_a_moved_name_that_the_frames_speak_against_is_told(run, refitted, fingerprint, caplog):
    proposed = run()
    run(block(fingerprint, {1: other(proposed, "brow", 1)}), refitted(lambda rows: rows["cluster"]))
    assert f"brow 1 is {other(proposed, 'brow', 1)} by the names moved to it" in caplog.text


@pytest.mark.parametrize("known", [True, False])
def test_names_that_cannot_be_moved_stop_the_run_with_a_command_to_copy(
    run, refitted, fingerprint, proposals, known
):
    given = block(fingerprint if known else {"brow": "elsewhere"}, {0: "BrowUp", 1: "BrowDown"})
    with pytest.raises(BadLabels) as caught:
        run(given, refitted(merged))
    message = str(caught.value)
    assert "mine.yaml, region brow" in message
    assert given["brow"]["model"] in message
    assert ("as the fits differ" if known else "none of its frames was known before") in message
    command = shlex.split(message[message.index("mimeline label") :])
    arguments = _parsed(command[1:])
    assert (arguments.results, arguments.file) == (proposals, run.file)


def test_a_cluster_that_is_left_open_stops_the_run_until_it_is_answered(run, fingerprint):
    with pytest.raises(BadLabels, match="brow 0: it lost its name.*mimeline label"):
        run(block(fingerprint, {0: "open", 1: "BrowUp"}))
    assert run(block(fingerprint, {0: "not sure", 1: "BrowUp"})) is not None


def test_names_that_this_very_fit_had_are_offered_where_they_were_kept(run, fingerprint):
    copy = kept_copy(run.file, "brow", fingerprint["brow"])
    with pytest.raises(BadLabels) as without:
        run(block(fingerprint, {0: "open"}))
    copy.write_text("")
    with pytest.raises(BadLabels) as beside:
        run(block(fingerprint, {0: "open"}))
    assert str(copy) in str(beside.value) and str(copy) not in str(without.value)


def test_clusters_that_have_one_thing_against_them_are_told_together(run):
    elsewhere = {"brow": "BrowUp", "eye": "Neutral"}
    given = {r: {"model": "elsewhere", "clusters": {0: name}} for r, name in elsewhere.items()}
    with pytest.raises(BadLabels, match="brow 0, 1, 2: none of its.*; eye 0, 1, 2: none of its"):
        run(given)


def test_of_many_reasons_why_a_run_stops_only_some_are_told(run, monkeypatch):
    monkeypatch.setattr("mimeline.annotation.labels.MOST_REASONS", 1)
    given = {r: {"model": "elsewhere", "clusters": {0: "Neutral"}} for r in ("brow", "eye")}
    with pytest.raises(BadLabels, match="brow 0, 1, 2: .*; and 1 more, which the page tells,"):
        run(given)


@pytest.mark.parametrize("share", range(0, 101, 10))
def test_whatever_a_refit_does_names_are_moved_by_their_frames_or_the_run_stops(
    run, refitted, fingerprint, proposals, share
):
    """Part of the frames of cluster 0 go to cluster 1, whose name is another."""
    names = {0: "BrowUp", 1: "BrowDown", 2: "Neutral"}
    given = block(fingerprint, names)

    def mixed(rows):
        goes = (rows["cluster"] == 0) & (rows["frame"] % 100 < share)
        return rows["cluster"].mask(goes, 1)

    world = refitted(mixed)
    now = tables.read(tables.CLUSTERS, world.clusters["brow"])["cluster"].to_numpy()
    was = recall(proposals / "label" / "fits", "brow", fingerprint["brow"])
    frames = was["cluster"].repeat(was["end_frame"] - was["start_frame"]).map(names).to_numpy()
    try:
        labels = run(given, world).loc["brow"]
    except BadLabels:
        assert share > 0
        return
    for cluster in set(now):
        borne = (frames[now == cluster] == labels.loc[cluster, "action"]).mean()
        assert labels.loc[cluster, "source"] == "moved"
        assert labels.loc[cluster, "confidence"] == pytest.approx(borne)
        assert borne >= 0.8


def test_an_old_cluster_that_its_fit_did_not_have_is_refused(run, refitted, fingerprint):
    with pytest.raises(BadLabels, match="cluster 9: found no such cluster"):
        run(block(fingerprint, {9: "BrowUp"}), refitted(turned))


def test_answers_of_the_same_fit_hold_as_they_are(segmented, tmp_path):
    clusters = tables.read(tables.CLUSTERS, segmented.clusters["brow"])
    answers = {0: Answer("BrowUp", "strong"), 1: Answer(same_as=0), 2: Answer()}
    own = RegionAnswers("f", answers)
    settled = settle("mine.yaml", own, "brow", "f", clusters, tmp_path, 0.8)
    assert settled.answers == answers
    assert (settled.moved, settled.unsafe, settled.kept) == ({}, {}, None)
    for nothing in (None, RegionAnswers("g")):
        settled = settle("mine.yaml", nothing, "brow", "f", clusters, tmp_path, 0.8)
        assert (settled.model, settled.answers, settled.unsafe) == ("f", {}, {})


def test_where_no_region_was_segmented_the_table_is_empty_and_says_why(segmented, tmp_path, run):
    world = SimpleNamespace(
        **{
            k: dict.fromkeys(REGIONS, v["mouth"])
            for k, v in vars(segmented).items()
            if k != "motion"
        }
    )
    out = [tmp_path / "label" / f"{name}.parquet" for name in ("proposed", "exemplars", "profiles")]
    inputs = (world.series, world.clusters, world.models, resource("proposals.csv"))
    exemplars(*inputs, *out, side="left", n_random=2, n_further=3, seed=0)
    assert run(world=world, results=tmp_path).empty
    assert tables.reason(tmp_path / "labels.parquet") == "no region could be segmented"
    assert run(run.names.read_text(), world, tmp_path).empty
