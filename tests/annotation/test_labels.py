import pandas as pd
import pytest
import yaml

from mimeline import tables
from mimeline.annotation.exemplars import exemplars
from mimeline.annotation.labels import label, read_labels
from mimeline.errors import BadLabels
from mimeline.ticc import TICC
from mimeline.vocabulary import resource


@pytest.fixture
def run(segmented, tmp_path):
    """Exemplars, then labels with a person's file, given as text or as what YAML holds."""

    def run(given=None, world=segmented, seed=0):
        file = None
        if given is not None:
            file = str(tmp_path / "mine.yaml")
            text = given if isinstance(given, str) else yaml.safe_dump(given)
            (tmp_path / "mine.yaml").write_text(text)
        names = ("proposed.parquet", "labels.yaml", "exemplars.parquet")
        out = [tmp_path / name for name in names]
        inputs = (world.series, world.clusters, world.models, resource("proposals.csv"))
        exemplars(*inputs, *out, side="left", n_random=2, seed=seed)
        label(out[0], world.models, tmp_path / "labels.parquet", file)
        labels = tables.read(tables.LABELS, tmp_path / "labels.parquet")
        labels = labels.set_index(["region", "cluster"])
        return labels, out[1].read_text(), tables.read(tables.EXEMPLARS, out[2])

    return run


@pytest.fixture(scope="session")
def fingerprint(segmented):
    return {region: TICC.load(segmented.models[region]).fingerprint() for region in ("brow", "eye")}


def block(fingerprint, clusters, region="brow"):
    return {region: {"model": fingerprint[region], "clusters": clusters}}


def other(labels, region, cluster):
    """An action of the brow that was not proposed for a cluster."""
    return "BrowDown" if labels.loc[(region, cluster), "action"] == "BrowUp" else "BrowUp"


def test_without_a_file_each_cluster_gets_a_proposed_name(run):
    labels, _, _ = run()
    assert set(labels.loc["brow", "action"]) == {"Neutral", "BrowUp", "BrowDown"}
    assert set(labels.loc["eye", "action"]) == {"Neutral", "EyeSquint", "EyeWiden"}
    assert set(labels["source"]) == {"proposed"}
    assert labels["note"].isna().all()


def test_a_region_that_was_not_segmented_is_left_out_and_the_others_go_on(run):
    labels, names, exemplars = run()
    assert set(labels.index.get_level_values("region")) == {"brow", "eye"}
    assert set(exemplars["region"]) == {"brow", "eye"}
    assert set(yaml.safe_load(names)) == {"brow", "eye"}


def test_shares_of_a_region_add_up_to_one_and_count_frames(run, segmented):
    labels, _, _ = run()
    assert labels.groupby("region")["share"].sum().tolist() == pytest.approx([1, 1])
    clusters = tables.read(tables.CLUSTERS, segmented.clusters["eye"])["cluster"]
    assert labels.loc[("eye", 1), "share"] == pytest.approx((clusters == 1).mean())


def test_every_cluster_shows_every_kind_of_exemplar_of_its_own(run, segmented):
    _, _, exemplars = run()
    kinds = exemplars.groupby(["region", "cluster"])["kind"].agg(set)
    assert len(kinds) == 6
    assert all(found == {"medoid", "border", "longest", "random"} for found in kinds)
    clusters = tables.read(tables.CLUSTERS, segmented.clusters["brow"])
    for shown in exemplars[exemplars["region"] == "brow"].itertuples():
        rows = clusters[clusters["clip_id"] == shown.clip_id]
        rows = rows[rows["frame"].between(shown.start_frame, shown.end_frame - 1)]
        assert set(rows["cluster"]) == {shown.cluster}


def test_exemplars_repeat_for_a_seed(run):
    first, again, third = (run(seed=seed)[2] for seed in (1, 1, 2))
    pd.testing.assert_frame_equal(first, again)
    assert not first.equals(third)


def test_a_persons_name_overrides_and_clusters_without_one_keep_the_proposal(run, fingerprint):
    proposed, _, _ = run()
    name = other(proposed, "brow", 1)
    labels, _, _ = run(block(fingerprint, {1: name}))
    assert labels.loc[("brow", 1), ["action", "source"]].tolist() == [name, "human"]
    rest = labels.index != ("brow", 1)
    pd.testing.assert_frame_equal(labels[rest], proposed[rest])


def test_notes_are_kept_even_where_they_look_like_numbers(run, fingerprint):
    entries = {
        0: {"action": "BrowUp", "note": "strong"},
        1: {"action": "BrowUp", "note": 3},
        2: {"action": "Neutral"},
    }
    labels, _, _ = run(block(fingerprint, entries))
    assert labels.loc["brow", "action"].tolist() == ["BrowUp", "BrowUp", "Neutral"]
    assert labels.loc["brow", "note"].fillna("-").tolist() == ["strong", "3", "-"]


def test_the_written_names_are_a_valid_label_file(run):
    proposed, names, _ = run()
    labels, again, _ = run(names)
    assert labels["action"].tolist() == proposed["action"].tolist()
    assert set(labels["source"]) == {"human"}
    assert again == names


def test_the_written_names_are_the_proposed_ones_whatever_a_person_wrote(run, fingerprint):
    _, plain, _ = run()
    given = block(fingerprint, {0: {"action": "Neutral", "note": "trembling: a lot"}})
    labels, names, _ = run(given)
    assert names == plain
    assert labels.loc[("brow", 0), "note"] == "trembling: a lot"


def test_names_for_another_fit_stop_the_run_and_say_what_to_do(run, fingerprint):
    with pytest.raises(BadLabels) as caught:
        run({"eye": {"model": "0123456789abcdef", "clusters": {0: "Neutral"}}})
    message = str(caught.value)
    assert "mine.yaml, region eye" in message
    assert "0123456789abcdef" in message
    assert fingerprint["eye"] in message
    assert "look at the exemplars" in message


@pytest.mark.parametrize(
    "name", ["Browup", "Smile", "EyeClose", None, 3, {"note": "x"}, ["BrowUp"]]
)
def test_an_action_that_the_region_does_not_have_is_refused(run, fingerprint, name):
    with pytest.raises(BadLabels, match="cluster 2: .*expected one of BrowUp, BrowDown, Neutral"):
        run(block(fingerprint, {2: name}))


def test_a_key_that_a_name_does_not_have_is_refused(run, fingerprint):
    with pytest.raises(BadLabels, match="cluster 0"):
        run(block(fingerprint, {0: {"action": "BrowUp", "notes": "strong"}}))


@pytest.mark.parametrize("cluster", [3, -1, "0", "brow"])
def test_a_cluster_that_does_not_exist_is_refused(run, fingerprint, cluster):
    with pytest.raises(BadLabels, match=f"cluster {cluster}: .*no such cluster.* 0, 1, 2"):
        run(block(fingerprint, {cluster: "BrowUp"}))


@pytest.mark.parametrize("region", ["nose", 7])
def test_a_region_that_does_not_exist_is_refused(run, fingerprint, region):
    given = block(fingerprint, {0: "BrowUp"}) | {region: {"model": "x", "clusters": {}}}
    with pytest.raises(BadLabels, match=f"{region!r}, expected one of brow, eye, mouth"):
        run(given)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("brow: [", "expected YAML"),
        ("brow: {model: \x07}", "expected YAML"),
        ("- brow\n- eye\n", "found a list"),
        ("BrowUp", "found a str"),
        ("brow: BrowUp", "region brow"),
        ("brow:\n  0: BrowUp", "keys model and clusters"),
        ("brow: {model: x, clusters: [BrowUp]}", "keys model and clusters"),
        ("brow: {model: x, clusters: {0: BrowUp, 1: Neutral, 0: Neutral}}", "key 0 a second time"),
        ("eye: {model: x, clusters: {}}\neye: {model: y, clusters: {}}", "key eye a second time"),
        ("brow: !!map [BrowUp]", "expected YAML"),
        ("!!python/object/apply:os.getcwd []", "expected YAML"),
    ],
)
def test_a_file_that_is_no_label_file_is_refused_with_its_name(tmp_path, text, message):
    path = tmp_path / "mine.yaml"
    path.write_text(text)
    with pytest.raises(BadLabels, match=message) as caught:
        read_labels(str(path))
    assert "mine.yaml" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_label_file_that_is_not_there_names_the_key():
    with pytest.raises(BadLabels, match="label.file"):
        read_labels("nowhere.yaml")


def test_an_empty_label_file_names_nothing(run):
    labels, _, _ = run("# nothing yet\n")
    assert set(labels["source"]) == {"proposed"}


def test_names_of_a_region_that_was_not_segmented_are_told(run, caplog):
    labels, _, _ = run({"mouth": {"model": "x", "clusters": {0: "Smile"}}})
    assert "mouth" not in labels.index.get_level_values("region")
    assert "mouth is not segmented, so its names" in caplog.text


def test_where_no_region_was_segmented_the_tables_are_empty_and_say_why(run, segmented, tmp_path):
    world = type(segmented)(
        series=dict.fromkeys(("brow", "eye", "mouth"), segmented.series["mouth"]),
        clusters=dict.fromkeys(("brow", "eye", "mouth"), segmented.clusters["mouth"]),
        models=dict.fromkeys(("brow", "eye", "mouth"), segmented.models["mouth"]),
    )
    labels, names, exemplars = run(world=world)
    assert labels.empty
    assert exemplars.empty
    assert tables.reason(tmp_path / "labels.parquet") == "no region could be segmented"
    assert tables.reason(tmp_path / "exemplars.parquet") == "no region could be segmented"
    assert run(names, world=world)[0].empty
