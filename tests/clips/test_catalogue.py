import json
from pathlib import Path

import pandas as pd
import pytest

from mimeline import tables
from mimeline.clips.admission import fault_of
from mimeline.clips.catalogue import catalogue, shard_of
from mimeline.errors import BadFile

OPTIONS = {"info": "info.json", "annotations": "acts.json"}


def record(start=10.0, end=16.0, source="abc", **more):
    box = {"top": 0.0, "bottom": 0.9, "left": 0.2, "right": 0.8}
    return {"ytb_id": source, "duration": {"start_sec": start, "end_sec": end}, "bbox": box} | more


@pytest.fixture
def run(tmp_path):
    def run(info, acts=None, shards=1, cut_s=None, **told):
        text = info if isinstance(info, str) else json.dumps(info)
        (tmp_path / "info.json").write_text(text)
        (tmp_path / "acts.json").write_text(json.dumps({"act": acts or {}} | told))
        paths = [tmp_path / f"{n}.parquet" for n in range(shards)]
        ledger = tmp_path / "ledger.parquet"
        catalogue(tmp_path, paths, ledger, "celebvtext", OPTIONS, cut_s, None, None)
        rows = tables.read(tables.LEDGER, ledger).set_index("clip_id")
        return tables.read_all(tables.CLIPS, paths).set_index("clip_id"), rows

    return run


def test_whole_second_times_of_the_source_become_seconds_of_the_clip(run):
    acts = {
        "a_0.mp4": [
            ["head wagging", ["0:0:9", "0:00:12", 3, 0]],
            ["talk", ["0:00:11", "0:01:00", 49, 1]],
        ]
    }
    clips, _ = run({"a_0.mp4": record()}, acts)
    assert list(clips.loc["a_0", "actions"]) == [
        {"name": "head_wagging", "start_s": 0.0, "end_s": 2.0, "uncertainty_s": 1.0},
        {"name": "talk", "start_s": 1.0, "end_s": 6.0, "uncertainty_s": 1.0},
    ]


def test_a_box_in_shares_tells_no_size_and_a_box_in_pixels_does(run):
    pixels = {"top": 10, "bottom": 610, "left": 5, "right": 517}
    clips, _ = run({"a_0.mp4": record(), "b_0.mp4": record(bbox=pixels)})
    assert pd.isna(clips.loc["a_0", "width"])
    assert clips.loc["b_0", ["width", "height"]].tolist() == [512, 600]


def test_what_lies_beyond_the_pictures_corner_counts_for_no_size(run):
    clips, _ = run({"a_0": record(bbox={"top": -50, "bottom": 600, "left": -300, "right": 300})})
    assert clips.loc["a_0", ["width", "height"]].tolist() == [300, 600]


def test_ids_that_are_no_plain_file_name_fail_and_a_leading_dash_does_not(run):
    paths = ["../../outside", "a/b", "/etc/passwd", "nul\x00byte", "..", ".hidden", "a b", ""]
    windows = ["CON", "nul.x", "Com1", "end.", "c:x", "a\\b"]
    bad = [*paths, *windows, "ä", "x" * 201, "-\n"]
    clips, ledger = run({"-abc_0.mp4": record(), **{name: record() for name in bad}})
    assert clips.index.tolist() == ["-abc_0"]
    assert (ledger.drop("-abc_0")["rule"] == "unsafe_id").all()
    assert len(ledger) == 1 + len(bad)
    assert "device on Windows: rename it" in ledger.loc["CON", "detail"]
    assert all(map(str.isprintable, ledger.index))
    assert ledger.index.str.len().max() < 300


def test_of_an_id_that_repeats_the_first_counts_and_the_others_are_numbered(run):
    good, bad = json.dumps(record(start=1)), json.dumps(record(start=2))
    keys = ["a_0", "a_0#2", "a_0.mp4", "b_0", "a_0"]
    pairs = (f'"{key}": {good if n == 0 else bad}' for n, key in enumerate(keys))
    clips, ledger = run("{" + ", ".join(pairs) + "}")
    assert clips["start_s"].to_dict() == {"a_0": 1, "b_0": 2}
    rules = ledger.loc[ledger["status"] == "failed", "rule"].to_dict()
    assert rules == {"a_0#2": "unsafe_id", "a_0#3": "repeated_id", "a_0#4": "repeated_id"}
    assert "a_0 stands in the catalogue before" in ledger.loc["a_0#3", "detail"]


def test_a_record_with_a_fault_takes_no_good_one_s_name(run):
    pairs = (f'"a_0": {json.dumps(record(start=start))}' for start in (99, 1))
    clips, ledger = run("{" + ", ".join(pairs) + "}")
    assert clips["start_s"].to_dict() == {"a_0": 1}
    assert ledger["rule"].dropna().to_dict() == {"a_0": "no_annotations", "a_0#2": "bad_times"}


def test_the_first_of_an_id_that_repeats_keeps_its_annotations(run):
    text = json.dumps(record())
    acts = {"a_0": [["nod", ["0:00:11", "0:00:12", 1, 0]]]}
    clips, ledger = run(f'{{"a_0": {text}, "a_0": {text}}}', acts)
    assert [act["name"] for act in clips.loc["a_0", "actions"]] == ["nod"]
    assert ledger["rule"].dropna().to_dict() == {"a_0#2": "repeated_id"}


def test_of_ids_that_differ_in_capitals_alone_the_first_counts(run):
    clips, ledger = run({"aB_0": record(), "Ab_0": record(), "b_0": record()})
    assert clips.index.tolist() == ["aB_0", "b_0"]
    assert ledger.loc["Ab_0", "rule"] == "case_collision"
    assert "aB_0" in ledger.loc["Ab_0", "detail"]


@pytest.mark.parametrize(
    ("start", "end"),
    [
        (5, 5),
        (5, 4),
        (-1, 4),
        (0, "NaN"),
        ("NaN", 4),
        (0, "Infinity"),
        (0, 1e300),
        ("-Infinity", 4),
    ],
)
def test_times_that_cannot_be_fail_their_clip_alone(run, start, end):
    text = json.dumps({"a_0": record(), "b_0": record(start=111, end=222)})
    clips, ledger = run(text.replace("111", str(start)).replace("222", str(end)), cut_s=1.0)
    assert set(clips["source_id"]) == {"abc"}
    assert ledger.loc["b_0", "rule"] == "bad_times"


@pytest.mark.parametrize(
    "edges",
    [
        (9, 3, 0, 700),
        (0.5, 0.5, 0, 1),
        (0, 1, 1.0, 1.5),
        (-0.5, 0, 0, 1),
        (0, 600, -512, 0),
        (0, 600.0, 5.0, 5.2),
        (0, 1e12, 0, 600),
        (0, float("nan"), 0, 1),
        (float("nan"),) * 4,
        (0, float("inf"), 0, 1),
    ],
)
def test_a_box_without_a_picture_in_it_fails_its_clip_alone(run, edges):
    box = dict(zip(("top", "bottom", "left", "right"), edges, strict=True))
    clips, ledger = run({"a_0": record(), "b_0": record(bbox=box)})
    assert clips.index.tolist() == ["a_0"]
    assert ledger.loc["b_0", "rule"] == "box_outside"


def test_what_a_reader_says_of_a_clip_stands_in_the_ledger(run):
    clips, ledger = run(
        {"a_0": record(), "b_0": record()},
        {"a_0": [["wink", ["0:01:00", "0:01:01", 1, 0]]]},
    )
    assert sorted(clips.index) == ["a_0", "b_0"]
    assert ledger["status"].tolist() == ["kept", "kept"]
    assert ledger["rule"].to_dict() == {"a_0": "outside_clip", "b_0": "no_annotations"}
    assert ledger.loc["a_0", "value"] == 1


def test_a_source_that_leads_out_of_the_folder_fails(run):
    clips, ledger = run({"a_0.mp4": record(source="../secret"), "b_0.mp4": record()})
    assert clips.index.tolist() == ["b_0"]
    assert ledger.loc["a_0", "rule"] == "unsafe_id"


def test_an_id_that_is_no_unicode_fails_and_can_be_read_about(run):
    clips, ledger = run('{"a\\ud800.mp4": ' + json.dumps(record()) + "}")
    assert clips.empty
    assert ledger.index.tolist() == ["a\\ud800"]


def test_a_box_in_shares_may_overshoot_the_picture(run):
    box = {"top": -0.01, "bottom": 1.02, "left": 0.0, "right": 1.0}
    clips, _ = run({"a_0.mp4": record(bbox=box)})
    assert pd.isna(clips.loc["a_0", "width"])


def test_annotations_that_tell_a_part_twice_stop_the_run(run, tmp_path):
    run({"a_0": record()})
    (tmp_path / "acts.json").write_text('{"act": {"a_0": []}, "act": {}}')
    out = [tmp_path / "0.parquet"], tmp_path / "ledger.parquet"
    with pytest.raises(BadFile, match="key 'act' twice"):
        catalogue(tmp_path, *out, "celebvtext", OPTIONS, None, None, None)


@pytest.mark.parametrize("text", ["", "[1, 2]", '{"a": ', '{"clips": [1]}'])
def test_a_file_that_is_no_catalogue_stops_the_run(run, text):
    with pytest.raises(BadFile, match="info.json"):
        run(text)


def test_clips_of_a_source_share_a_shard_whatever_else_there_is(run):
    info = {f"{source}_{n}.mp4": record(source=source) for source in "abcdefgh" for n in range(3)}
    clips, _ = run(info, shards=3)
    assert (clips.groupby("source_id")["shard"].nunique() == 1).all()
    assert clips["shard"].nunique() > 1
    assert all(clips.loc["a_0", "shard"] == shard_of("a", 3) for _ in range(2))


def test_a_take_longer_than_the_limit_is_cut_into_consecutive_clips(run):
    acts = {"a.mp4": [["talk", ["0:00:08", "0:00:12", 4, 0]]]}
    clips, _ = run({"a.mp4": record(start=0.0, end=25.0)}, acts, cut_s=10)
    assert clips.index.tolist() == ["a_000", "a_001", "a_002"]
    assert clips["start_s"].tolist() == [0, 10, 20]
    assert clips["end_s"].tolist() == [10, 20, 25]
    assert [a["end_s"] for a in clips.loc["a_000", "actions"]] == [10.0]
    assert [a["end_s"] for a in clips.loc["a_001", "actions"]] == [2.0]


def test_what_a_take_shows_is_cut_with_it(run):
    acts = {"a": [["talk", ["0:00:08", "0:00:12", 4, 0]], ["nod", ["0:00:20", "0:00:20", 0, 1]]]}
    told = {"a": [["happy", ["0:00:00", "0:00:12", 12, 0]], ["sad", ["0:00:12", "0:00:25", 1, 1]]]}
    clips, _ = run({"a": record(start=0.0, end=25.0)}, acts, cut_s=10, emotion=told)
    assert clips["emotion"].tolist() == ["happy", "sad", "sad"]
    assert [e["name"] for e in clips.loc["a_001", "emotions"]] == ["happy", "sad"]
    assert [a["name"] for a in clips.loc["a_001", "actions"]] == ["talk", "nod"]
    (nod,) = clips.loc["a_002", "actions"]
    assert (nod["start_s"], nod["end_s"], nod["uncertainty_s"]) == (0.0, 0.0, 1.0)


def test_an_action_that_may_reach_over_a_cut_is_told_on_both_sides(run):
    acts = {"a": [["turn", ["0:00:08", "0:00:10", 2, 0]], ["nod", ["0:00:21", "0:00:22", 1, 1]]]}
    clips, _ = run({"a": record(start=0.0, end=30.0)}, acts, cut_s=10)
    told = clips["actions"].map(
        lambda acts: [(act["name"], act["start_s"], act["end_s"]) for act in acts]
    )
    assert told["a_000"] == [("turn", 8.0, 10.0)]
    assert told["a_001"] == [("turn", 0.0, 0.0)]  # until 11 s, perhaps
    assert told["a_002"] == [("nod", 1.0, 2.0)]


def test_a_catalogue_that_would_be_cut_into_too_many_clips_stops_the_run(run):
    with pytest.raises(BadFile, match="more than 1,000,000 clips"):
        run({"a": record(start=0.0, end=600_000.0)}, cut_s=0.5)


@pytest.mark.parametrize(
    "video",
    ["../x.mp4", "/etc/passwd", "a/../../x", "a/../x", "a\\b", "C:x", "", "x\x00", "\ud800"],
)
def test_a_path_that_leads_out_of_the_folder_fails_its_clip(video):
    row = {"clip_id": "a", "source_id": "a", "start_s": 0.0, "end_s": 1.0}
    assert fault_of(row | {"video": video})["rule"] == "unsafe_path"
    assert fault_of(row | {"video": "here/x.mp4"}) is None


def test_files_of_a_folder_are_takes_as_long_as_their_results(tmp_path, real_data):
    tracker = {
        "format": "livelink",
        "options": {"folder": ".", "fps": "30", "timecode_base": 60, "angle_unit": "radians"},
        "bad_values": "fail",
    }
    out, ledger = tmp_path / "clips.parquet", tmp_path / "ledger.parquet"
    options = {"pattern": "*.csv", "exclude": [], "subject": "me", "subject_pattern": None}
    catalogue(real_data / "arkit_livelink", [out], ledger, "files", options, 10.0, tracker, None)
    clips = tables.read(tables.CLIPS, out)
    assert len(clips) == 14
    assert clips["end_s"].max() == pytest.approx(4033 / 30)
    assert set(clips["subject_id"]) == {"me"}


def test_people_are_found_in_the_names_of_takes(tmp_path):
    golden = Path(__file__).parents[1] / "tracking" / "golden" / "livelink" / "turns_left.csv"
    for name in ("M030_happy", "M030_sad", "W009_sad", "nobody"):
        (tmp_path / f"{name}.csv").write_bytes(golden.read_bytes())
    block = {"folder": ".", "fps": "30", "timecode_base": 60, "angle_unit": "radians"}
    tracker = {"format": "livelink", "options": block, "bad_values": "fail"}
    out = tmp_path / "clips.parquet"
    options = {"pattern": "*", "exclude": [], "subject": None, "subject_pattern": r"^[A-Z]\d+"}
    catalogue(tmp_path, [out], tmp_path / "l.parquet", "files", options, None, tracker, None)
    people = tables.read(tables.CLIPS, out)["subject_id"]
    assert people.fillna("").tolist() == ["M030", "M030", "W009", ""]


def test_where_no_take_can_be_read_the_run_stops_with_what_is_wrong(tmp_path):
    golden = Path(__file__).parents[1] / "tracking" / "golden" / "livelink" / "turns_left.csv"
    for name in ("a", "b"):
        rows = golden.read_text().replace(",0.0", ",50.0")  # per cent
        (tmp_path / f"{name}.csv").write_text(rows)
    block = {"folder": ".", "fps": "30", "timecode_base": 60, "angle_unit": "radians"}
    tracker = {"format": "livelink", "options": block, "bad_values": "fail"}
    options = {"pattern": "*", "exclude": [], "subject": None, "subject_pattern": None}
    out = ([tmp_path / "clips.parquet"], tmp_path / "ledger.parquet")
    with pytest.raises(BadFile, match="none of the 2 takes can be read: found 50"):
        catalogue(tmp_path, *out, "files", options, None, tracker, None)


def test_a_real_catalogue_reads_whole(tmp_path, real_data):
    out, ledger = tmp_path / "clips.parquet", tmp_path / "ledger.parquet"
    options = {"info": "celebvtext_info-sample.json", "annotations": None}
    catalogue(real_data / "celebv", [out], ledger, "celebvtext", options, None, None, None)
    clips = tables.read(tables.CLIPS, out)
    assert len(clips) == 43
    assert clips["clip_id"].str.startswith("-").sum() == 1
    assert tables.read(tables.LEDGER, ledger)["clip_id"].tolist() == clips["clip_id"].tolist()


def test_a_folder_without_takes_or_no_folder_says_so(tmp_path):
    options = {"pattern": "*.csv", "exclude": [], "subject": "me", "subject_pattern": None}
    out = ([tmp_path / "clips.parquet"], tmp_path / "ledger.parquet")
    tracker = {"format": "livelink", "options": {"folder": "."}, "bad_values": "fail"}
    with pytest.raises(BadFile, match=r"no Live Link Face CSV among \*.csv"):
        catalogue(tmp_path, *out, "files", options, None, tracker, None)
    with pytest.raises(BadFile, match="no such folder"):
        catalogue(tmp_path / "nowhere", *out, "files", options, None, {}, None)
