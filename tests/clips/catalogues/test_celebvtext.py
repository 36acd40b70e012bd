import json
import pickle

import pytest

from mimeline.clips.catalogues.celebvtext import read
from mimeline.errors import BadFile

SHARES = {"top": 0.0, "bottom": 0.9, "left": 0.2, "right": 0.8}
PIXELS = {"top": 0, "bottom": 937, "left": 849, "right": 1872}


def record(source="0-5BrmyFsYM", start=10.0, end=16.0, bbox=SHARES):
    return {"ytb_id": source, "duration": {"start_sec": start, "end_sec": end}, "bbox": bbox}


def act(*entries):
    return [[name, [since, until, 1, 0]] for name, since, until in entries]


@pytest.fixture
def catalogue(tmp_path):
    def catalogue(info, told=None, file="annotations.json"):
        (tmp_path / "info.json").write_text(info if isinstance(info, str) else json.dumps(info))
        if told is not None and file.endswith(".pkl"):
            (tmp_path / file).write_bytes(pickle.dumps(told))
        elif told is not None:
            (tmp_path / file).write_text(told if isinstance(told, str) else json.dumps(told))
        rows, bad = read(tmp_path, "info.json", None if told is None else file)
        return {row["clip_id"]: row for row in rows}, dict(bad)

    return catalogue


def names(row, column="actions"):
    return [told["name"] for told in row[column]]


def test_the_flat_file_and_the_one_in_a_wrapper_say_the_same(catalogue):
    records = {"0-5BrmyFsYM_0.mp4": record(bbox=PIXELS)}
    flat, _ = catalogue(records)
    wrapped, _ = catalogue({"clips": records})
    assert flat == wrapped
    assert flat["0-5BrmyFsYM_0"]["width"] == 1872 - 849


@pytest.mark.parametrize("ending", ["", ".mp4", ".mp4.mp4"])
def test_the_endings_of_keys_are_no_part_of_an_id(catalogue, ending):
    rows, _ = catalogue(
        {f"a_0{ending}": record()}, {"act": {"a_0": act(("nod", "0:0:11", "0:0:12"))}}
    )
    assert names(rows["a_0"]) == ["nod"]


def test_clips_of_the_second_set_that_share_an_id_are_clips_of_their_own(catalogue):
    rows, bad = catalogue(
        {
            "clips_set1": {"a_35": record(start=50, end=60), "b_1": record()},
            "clips_set2": {"a_35": record(start=70, end=80), "c_1": record()},
        }
    )
    assert set(rows) == {"a_35", "b_1", "a_35_set2", "c_1"}
    assert rows["a_35_set2"]["start_s"] == 70
    assert not bad


def test_annotations_of_two_sets_are_numbered_in_the_order_of_time(catalogue):
    info = {
        "clips_set1": {"a_35": record(start=70, end=80)},
        "clips_set2": {"a_35": record(start=50, end=60)},
    }
    told = {
        "a_35_2": act(("nod", "0:00:52", "0:00:53")),
        "a_35_10": act(("smile", "0:01:12", "0:01:13")),
    }
    rows, _ = catalogue(info, {"act": told})
    assert names(rows["a_35_set2"]) == ["nod"]
    assert names(rows["a_35"]) == ["smile"]


def test_frames_without_a_rate_are_not_taken_for_seconds(catalogue):
    frames = record() | {"duration": {"start_frame": 415.29, "end_frame": 420.88}}
    rows, bad = catalogue({"clips": {"00-30GQl0TM_7": frames, "a_0": record()}})
    assert list(rows) == ["a_0"]
    assert "no frame rate" in str(bad["00-30GQl0TM_7"])


def test_a_key_that_stands_twice_leaves_two_records(tmp_path):
    one, other = json.dumps(record(start=1, end=9)), json.dumps(record(start=20, end=29))
    (tmp_path / "info.json").write_text(f'{{"a_0": {one}, "b_0": {one}, "a_0": {other}}}')
    rows, _ = read(tmp_path, "info.json", None)
    assert [(row["clip_id"], row["start_s"]) for row in rows] == [
        ("a_0", 1),
        ("b_0", 1),
        ("a_0", 20),
    ]


def test_a_record_that_says_a_thing_twice_is_none(catalogue):
    twice = '{"a_0": {"ytb_id": "x", "ytb_id": "y"}, "b_0": ' + json.dumps(record()) + "}"
    rows, bad = catalogue(twice)
    assert list(rows) == ["b_0"]
    assert "key 'ytb_id' twice" in str(bad["a_0"])


@pytest.mark.parametrize(
    ("clip", "key"), [("-abc_0", "abc_0"), ("abc_0", "_abc_0"), ("_a_0", "-a_0")]
)
def test_annotations_are_found_under_a_name_that_gained_or_lost_a_dash(catalogue, clip, key):
    rows, _ = catalogue({f"{clip}.mp4": record()}, {"act": {key: act(("nod", "0:0:11", "0:0:12"))}})
    assert names(rows[clip]) == ["nod"]


def test_annotations_that_could_be_of_two_clips_are_of_none(catalogue, caplog):
    info = {"-abc_0": record(), "_abc_0": record(), "d_0": record()}
    told = {"act": {"abc_0": act(("nod", "0:0:11", "0:0:12"))}}
    rows, _ = catalogue(info, told)
    notes = {clip: row["notes"] for clip, row in rows.items()}
    assert "several" in notes["-abc_0"][0][1]["detail"]
    assert notes["-abc_0"] == notes["_abc_0"] != notes["d_0"]
    assert "in doubt for 2 clips: -abc_0, _abc_0" in caplog.text


def test_its_own_annotations_go_before_those_of_a_name_alike(catalogue):
    told = {"act": {"abc_0": act(("nod", "0:0:11", "0:0:12")), "-abc_0": []}}
    rows, _ = catalogue({"abc_0": record(), "-abc_0": record()}, told)
    assert [names(rows[clip]) for clip in ("abc_0", "-abc_0")] == [["nod"], []]


def test_whole_seconds_of_the_source_become_seconds_of_the_clip(catalogue):
    told = act(("head wagging", "0:0:9", "0:00:12"), ("Talk", "0:00:11", "0:01:00"))
    rows, _ = catalogue({"a_0": record()}, {"act": {"a_0": told}})
    edges = [(a["start_s"], a["end_s"], a["uncertainty_s"]) for a in rows["a_0"]["actions"]]
    assert names(rows["a_0"]) == ["head_wagging", "talk"]
    assert edges == [(0.0, 2.0, 1.0), (1.0, 6.0, 1.0)]


def test_an_action_just_beside_its_clip_is_at_its_edge_and_one_far_from_it_is_told_of(catalogue):
    told = act(("nod", "0:0:8", "0:0:9"), ("turn", "0:0:17", "0:0:20"), ("wink", "0:1:0", "0:1:1"))
    rows, _ = catalogue({"a_0": record()}, {"act": {"a_0": told}})
    assert [(a["name"], a["start_s"], a["end_s"]) for a in rows["a_0"]["actions"]] == [
        ("nod", 0.0, 0.0),
        ("turn", 6.0, 6.0),
    ]
    ((rule, facts),) = rows["a_0"]["notes"]
    assert (rule, facts["value"], facts["detail"]) == ("outside_clip", 1, "wink 50 to 51 s")


@pytest.mark.parametrize(
    "told",
    [
        act(("nod", "0:0:12", "0:0:11")),
        act(("nod", "soon", "0:0:11")),
        act(("nod", 10, 11)),
        act(("", "0:0:10", "0:0:11")),
        act(("a\nb", "0:0:10", "0:0:11")),
        [["nod"]],
        ["nod"],
        "nod",
        5,
        None,
        act(*[("nod", "0:0:10", "0:0:11")] * 1001),
    ],
)
def test_a_clip_whose_actions_cannot_be_read_is_not_taken_for_one_without(catalogue, told):
    rows, bad = catalogue({"a_0": record(), "b_0": record()}, {"act": {"a_0": told}})
    assert list(rows) == ["b_0"]
    assert "annotations.json, record a_0: found" in str(bad["a_0"])


def test_appearance_and_light_become_attributes_where_they_are_set(catalogue):
    app = {
        "scar": [""],
        "mole": ["mole"],
        "freckle": ["left cheek"],
        "lighting": [["frontal", ["0:0:10", "0:0:16", 6]]],
    }
    rows, _ = catalogue({"a_0": record()}, {"app": {"a_0": app}})
    assert rows["a_0"]["attributes"] == ["mole", "freckle:left_cheek", "lighting:frontal"]


def test_a_light_that_changes_is_no_attribute_of_the_clip(catalogue):
    light = [["frontal", ["0:0:10", "0:0:12", 2]], ["back", ["0:0:12", "0:0:16", 4]]]
    rows, _ = catalogue({"a_0": record()}, {"app": {"a_0": {"lighting": light}}})
    assert rows["a_0"]["attributes"] == []
    ((rule, facts),) = rows["a_0"]["notes"]
    assert (rule, facts["detail"]) == ("attributes_in_part", "lighting:frontal; lighting:back")


def test_the_published_pickle_reads_as_json_does(catalogue):
    told = {
        "act": {"a_0": act(("nod", "0:0:11", "0:0:12"))},
        "app": {"a_0": {"lighting": [["frontal", ["0:0:10", "0:0:16", 6]]]}},
    }
    by_json, _ = catalogue({"a_0": record()}, told)
    by_pickle, _ = catalogue({"a_0": record()}, told, "annotations.pkl")
    assert by_pickle == by_json
    assert names(by_pickle["a_0"]) == ["nod"]


class Call:
    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return open, (str(self.path), "w")


def test_a_pickle_that_would_run_something_is_refused_and_runs_nothing(catalogue, tmp_path):
    target = tmp_path / "made"
    with pytest.raises(BadFile, match=r"annotations.pkl: found the name .*open in a pickle"):
        catalogue({"a_0": record()}, {"act": {"a_0": Call(target)}}, "annotations.pkl")
    assert not target.exists()


@pytest.mark.parametrize(
    ("content", "found", "remedy"),
    [
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n", "Git LFS", "git lfs pull"),
        (b"<!DOCTYPE html><title>Drive</title>", "HTML page", "Download it again"),
        (b"#EXTM3U\n", "playlist", "again"),
        (b"", "an empty file", "again"),
        (b"PK\x03\x04", "ZIP", "Unpack it"),
        (b'{"a_0": {"ytb_id"', "char", "again"),
        (b'"\xff"', "byte 2 that is no UTF-8", "again"),
        (b"[" * 100_000, "deep nesting", "again"),
        (b'{"a": 1' + b"0" * 5000 + b"}", "digits", "again"),
        (b"[]", "list", "again"),
    ],
)
def test_a_file_that_is_no_catalogue_gives_itself_away(tmp_path, content, found, remedy):
    (tmp_path / "info.json").write_bytes(content)
    (tmp_path / "good.json").write_text(json.dumps({"a_0": record()}))
    for info, annotations in (("info.json", None), ("good.json", "info.json")):
        with pytest.raises(BadFile, match=rf"info.json: found .*{found}.*{remedy}"):
            read(tmp_path, info, annotations)


def test_a_file_beyond_all_measure_is_not_read(tmp_path):
    with open(tmp_path / "info.json", "wb") as file:
        file.truncate(2 << 30)
    with pytest.raises(BadFile, match="at most 128 MiB"):
        read(tmp_path, "info.json", None)


def test_a_catalogue_of_the_sister_set_says_whose_it_is(catalogue):
    with pytest.raises(BadFile, match="Set catalogue.format to celebvhq"):
        catalogue({"meta_info": {}, "clips": {"a_0": record()}})


def test_annotations_without_any_of_their_parts_are_none(catalogue):
    with pytest.raises(BadFile, match="none of act, app and emotion"):
        catalogue({"a_0": record()}, {"a_0": []})


def test_published_annotations_fit_the_published_clips(tmp_path, real_data):
    samples = json.loads((real_data / "celebv" / "annotation_samples.json").read_text())
    (sample,) = (told for told in samples["records"] if "app" in told)
    told = {kind: {"oC9r-CTbToE_0_0": sample[kind]} for kind in ("act", "app")}
    (tmp_path / "told.json").write_text(json.dumps(told))
    info = "celebvtext_info-sample.json"
    rows, bad = read(real_data / "celebv", info, str(tmp_path / "told.json"))
    row = next(row for row in rows if row["clip_id"] == "oC9r-CTbToE_0_0")
    assert (len(rows), bad) == (43, [])
    assert [(a["name"], a["start_s"]) for a in row["actions"]] == [("talk", 0.0), ("smile", 0.0)]
    assert row["actions"][0]["end_s"] == pytest.approx(76 - 58.07)
    assert row["attributes"] == ["lighting:frontal"]
    assert sum("notes" in row for row in rows) == 43


@pytest.fixture
def descriptions(tmp_path):
    (tmp_path / "info.json").write_text(json.dumps({"-a_0": record(), "b_0": record()}))
    for folder, name, lines in (
        ("action", "a_0.txt", b"She  nods.\nShe talks.\n\n"),
        ("action", "b_0.txt", b"He \x1b[2Jsings \xff.\r\n"),
        ("light", "-a_0.txt", b"The light is soft."),
    ):
        (tmp_path / folder).mkdir(exist_ok=True)
        (tmp_path / folder / name).write_bytes(lines)
    return tmp_path


def test_descriptions_are_the_lines_of_a_clips_files(descriptions):
    rows, _ = read(descriptions, "info.json", None, ["action", "light"])
    texts = {row["clip_id"]: row["texts"] for row in rows}
    assert texts["-a_0"] == ["She nods.", "She talks.", "The light is soft."]
    assert texts["b_0"] == ["He \\x1b[2Jsings \\xff."]


def test_a_folder_without_descriptions_says_so(descriptions):
    (descriptions / "empty").mkdir()
    for folder in ("empty", "nowhere"):
        with pytest.raises(BadFile, match=rf"{folder}: found .*Check catalogue.celebvtext.texts"):
            read(descriptions, "info.json", None, [folder])
