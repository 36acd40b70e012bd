import json
from pathlib import Path

import pandas as pd
import pytest

from mimeline import tables
from mimeline.clips.catalogue import catalogue, shard_of
from mimeline.errors import BadFile

OPTIONS = {"info": "info.json", "annotations": "acts.json"}


def record(start=10.0, end=16.0, source="abc", **more):
    box = {"top": 0.0, "bottom": 0.9, "left": 0.2, "right": 0.8}
    return {"ytb_id": source, "duration": {"start_sec": start, "end_sec": end}, "bbox": box} | more


@pytest.fixture
def run(tmp_path):
    def run(info, acts=None, shards=1, cut_s=None):
        text = info if isinstance(info, str) else json.dumps(info)
        (tmp_path / "info.json").write_text(text)
        (tmp_path / "acts.json").write_text(json.dumps({"act": acts or {}}))
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
        {"name": "head_wagging", "start_s": 0.0, "end_s": 2.0},
        {"name": "talk", "start_s": 1.0, "end_s": 6.0},
    ]


def test_a_box_in_shares_tells_no_size_and_a_box_in_pixels_does(run):
    pixels = {"top": 10, "bottom": 610, "left": 5, "right": 517}
    clips, _ = run({"a_0.mp4": record(), "b_0.mp4": record(bbox=pixels)})
    assert pd.isna(clips.loc["a_0", "width"])
    assert clips.loc["b_0", ["width", "height"]].tolist() == [512, 600]


def test_ids_that_are_no_plain_file_name_fail_and_a_leading_dash_does_not(run):
    hostile = ["../../outside", "a/b", "/etc/passwd", "nul\x00byte", "..", ".hidden", "a b", ""]
    clips, ledger = run({"-abc_0.mp4": record(), **{name: record() for name in hostile}})
    assert clips.index.tolist() == ["-abc_0"]
    assert (ledger.drop("-abc_0")["rule"] == "unsafe_id").all()
    assert len(ledger) == 1 + len(hostile)


@pytest.mark.parametrize(
    "bad",
    [
        {"ytb_id": "x"},
        record(start=5, end=5),
        record(start="soon"),
        record(bbox=None),
        record(ytb_id=5),
        record(subject=5),
        record(bbox={"top": 9, "bottom": 3, "left": 0, "right": 700}),
        "no record",
        None,
    ],
)
def test_a_record_that_is_none_fails_and_the_rest_goes_on(run, bad):
    clips, ledger = run({"good_0.mp4": record(), "bad_0.mp4": bad})
    assert clips.index.tolist() == ["good_0"]
    assert ledger.loc["bad_0", ["status", "rule"]].tolist() == ["failed", "unreadable"]
    assert "info.json, record bad_0.mp4: found" in ledger.loc["bad_0", "detail"]


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


@pytest.mark.parametrize("info", [{"clips": [1]}, {"a": record(), "a.mp4": {}}])
def test_a_catalogue_that_would_lose_a_clip_stops_the_run(run, info):
    with pytest.raises(BadFile):
        run(info)


@pytest.mark.parametrize("text", ["", "[1, 2]", '{"a": ', '{"a_0.mp4": {}, "a_0.mp4": {}}'])
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


def test_a_folder_without_takes_or_no_folder_says_so(tmp_path):
    options = {"pattern": "*.csv", "exclude": [], "subject": "me", "subject_pattern": None}
    out = ([tmp_path / "clips.parquet"], tmp_path / "ledger.parquet")
    tracker = {"format": "livelink", "options": {"folder": "."}, "bad_values": "fail"}
    with pytest.raises(BadFile, match=r"no Live Link Face CSV among \*.csv"):
        catalogue(tmp_path, *out, "files", options, None, tracker, None)
    with pytest.raises(BadFile, match="no such folder"):
        catalogue(tmp_path / "nowhere", *out, "files", options, None, {}, None)
