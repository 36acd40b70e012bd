import csv
import io
import logging

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mimeline import tables
from mimeline.clips.catalogues import table
from mimeline.errors import BadFile, MimelineError, MissingColumn, NoSuchFile
from mimeline.media.limits import Limits

SMALL = settings(
    max_examples=50, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


@pytest.fixture
def data(tmp_path):
    return tmp_path


@pytest.fixture
def read(data):
    """Reads a table from its text or bytes, or from columns as Parquet."""

    def read(content, file="clips.csv"):
        if isinstance(content, dict):
            file = "clips.parquet"
            pq.write_table(pa.table(content), data / file)
        else:
            raw = content.encode() if isinstance(content, str) else content
            (data / file).write_bytes(raw)
        return table.read(data, file, Limits())

    return read


def test_a_row_tells_all_that_the_clips_table_has(data, put, catalogued):
    put(data, "films/x.mp4")
    (data / "clips.csv").write_text(
        "clip_id,video,start_s,end_s,subject_id,emotion,actions,attributes,texts,"
        "bbox_top,bbox_bottom,bbox_left,bbox_right\n"
        "007,films/x.mp4,0.5,2.5,NA,Happy,smile@0.5-1.5~0.2; head wagging,"
        'male;Eye glasses,"He smiles; at last.|A man.",10,60,20,80\n'
    )
    (clip,) = catalogued(data, "table").clips.reset_index().to_dict("records")
    assert [clip[k] for k in ("clip_id", "source_id", "subject_id", "video")] == [
        *("007", "films_x", "NA", "films/x.mp4")
    ]
    assert [clip[k] for k in ("start_s", "end_s", "width", "height")] == [0.5, 2.5, 60, 50]
    assert [clip[f"bbox_{side}"] for side in ("top", "bottom", "left", "right")] == [10, 60, 20, 80]
    throughout = {"start_s": 0.0, "end_s": 2.0, "uncertainty_s": None}
    assert list(clip["actions"]) == [
        {"name": "smile", "start_s": 0.5, "end_s": 1.5, "uncertainty_s": 0.2},
        {"name": "head_wagging"} | throughout,
    ]
    assert clip["emotion"] == "happy" and list(clip["emotions"]) == [{"name": "happy"} | throughout]
    assert list(clip["attributes"]) == ["male", "eye_glasses"]
    assert list(clip["texts"]) == ["He smiles; at last.", "A man."]


def test_times_that_are_not_told_are_the_videos(data, put, catalogued):
    put(data, "x.mp4")
    (data / "clips.csv").write_text("clip_id,video,start_s\na,x.mp4,\nb,x.mp4,1\nc,y.mp4,1\n")
    found = catalogued(data, "table")
    assert found.clips[["start_s", "end_s"]].to_numpy().tolist() == [[0, 3], [1, 3]]
    assert found.clips[["width", "height"]].to_numpy().tolist() == [[96, 64], [96, 64]]
    assert "y.mp4: found no such file" in found.ledger.loc["c", "detail"]


def test_of_several_emotions_the_one_shown_longest_in_all_is_the_clips_own(data, catalogued):
    told = "happy@0-1;sad@1-2.5;happy@2.5-3.5"
    (data / "clips.csv").write_text(f"clip_id,source_id,end_s,emotions\na,s,5,{told}\n")
    assert catalogued(data, "table").clips.loc["a", "emotion"] == "happy"


def test_a_runs_own_table_of_clips_is_a_catalogue(data, catalogued):
    moments = [
        {"name": "nod", "start_s": second, "end_s": second, "uncertainty_s": 1.0}
        for second in (0.0, 2.0, 6.0)
    ]
    clip = {"clip_id": "a", "source_id": "s", "start_s": 4.0, "end_s": 10.0, "actions": moments}
    told = {"emotion": "sad", "emotions": [], "attributes": ["male"], "texts": ["He nods."]}
    rows = pd.DataFrame([clip | told], columns=tables.CLIPS.schema.names).assign(shard=0)
    tables.write(tables.CLIPS, rows, data / "clips.parquet")
    (again,) = (
        catalogued(data, "table", file="clips.parquet").clips.reset_index().to_dict("records")
    )
    assert list(again["actions"]) == moments
    assert (again["start_s"], again["emotion"], list(again["texts"])) == (4.0, "sad", ["He nods."])


def test_ids_stay_the_text_that_they_are(read):
    ids = ["007", "1e5", "NA", "null", "-x", "1.0", "True"]
    lines = "".join(f"{i},{i},1\n" for i in ids)
    rows, bad = read(f"clip_id,source_id,end_s\n{lines}")
    assert [row["clip_id"] for row in rows] == [row["source_id"] for row in rows] == ids
    assert bad == []
    rows, bad = read({"clip_id": ["007", None], "source_id": ["NA", "b"], "end_s": [1.0, 2.0]})
    assert rows[0]["clip_id"] == "007" and rows[0]["source_id"] == "NA"
    assert [name for name, _ in bad] == ["row 2"]


@pytest.mark.parametrize(
    ("column", "cell", "found"),
    [
        ("end_s", "soon", "'soon', expected a number"),
        ("end_s", "1,5", "'1,5', expected a number"),
        ("end_s", "nan", "'nan'"),
        ("end_s", "inf", "'inf'"),
        ("end_s", "1_0", "'1_0'"),
        ("width", "0", "'0', expected a number of pixels"),
        ("width", "12.5", "'12.5'"),
        ("width", "1e30", "'1e30'"),
        ("actions", "smile@2-1", "smile from 2 to 1 s"),
        ("actions", "smile@-1-2", "'smile@-1-2'"),
        ("actions", "smile@1", "'smile@1'"),
        ("actions", "@1-2", "'@1-2'"),
        ("actions", "x" * 200, "where a name belongs"),
        ("emotion", "a\x1b[2J", "where a name belongs"),
        ("attributes", "\x00", "where a name belongs"),
        ("texts", "a\x07", r"'a\x07'"),
    ],
)
def test_a_bad_cell_is_a_bad_record_of_its_row_alone(read, column, cell, found):
    good = {"clip_id": "good", "source_id": "s", "end_s": "5"}
    buffer = io.StringIO()
    sheet = csv.DictWriter(buffer, list(good | {column: ""}))
    sheet.writeheader()
    sheet.writerows([good | {"clip_id": "bad", column: cell}, good])
    rows, ((name, error),) = read(buffer.getvalue())
    assert [row["clip_id"] for row in rows] == ["good"] and name == "bad"
    assert f"clips.csv, line 2, column {column}: found" in str(error) and found in str(error)


def test_an_action_past_the_clip_s_end_is_cut_to_it_or_left_out_and_told(data, catalogued):
    (data / "clips.csv").write_text(
        "clip_id,source_id,end_s,actions,emotions\n"
        "a,s,3,smile@0-3.2;nod@4-5;blink@3.4-4~0.5,sad@7-8\nb,s,3,smile@0-3,\n"
    )
    found = catalogued(data, "table")
    times = [(i["name"], i["start_s"], i["end_s"]) for i in found.clips.loc["a", "actions"]]
    assert times == [("smile", 0.0, 3.0), ("blink", 3.0, 3.0)]
    assert len(found.clips.loc["a", "emotions"]) == 0
    row = found.ledger.loc["a"]
    assert (row["status"], row["rule"], row["value"]) == ("kept", "outside_clip", 2)
    assert row["detail"] == "nod 4 to 5 s; sad 7 to 8 s"
    assert found.ledger["rule"].count() == 1


@pytest.mark.parametrize("video", ["../x.mp4", "/etc/x.mp4", "..\\x.mp4", "C:\\x.mp4"])
def test_a_path_that_leads_out_is_told_as_it_stands(data, catalogued, video):
    (data / "clips.csv").write_text(f"clip_id,video\na,{video}\n")
    row = catalogued(data, "table").ledger.loc["a"]
    assert row["rule"] == "unsafe_path" and f"'{video}'" in row["detail"]


def test_a_row_of_another_length_is_a_bad_record(read):
    rows, bad = read("clip_id,source_id,end_s\na,s\nb,s,1,1\n\n,s,1\nc,,1\nd,s,\ne,s,1\n")
    assert [row["clip_id"] for row in rows] == ["e"]
    assert [
        (name, str(error).partition(": found ")[2].partition(",")[0]) for name, error in bad
    ] == [
        ("a", "2 cells"),
        ("b", "4 cells"),
        ("line 5", "no clip_id"),
        ("c", "no source_id"),
        ("d", "no end_s"),
    ]


def test_a_box_needs_four_edges(read):
    _, ((_, error),) = read("clip_id,source_id,end_s,bbox_top,bbox_left\na,s,1,0.5,\n")
    assert "bbox_top alone, expected all four edges" in str(error)


def test_times_that_run_backwards_and_paths_that_lead_out_are_told_by_the_stage(data, catalogued):
    (data / "clips.csv").write_text(
        "clip_id,source_id,start_s,end_s,video,emotion\n"
        "a,s,5,2,x.mp4,sad\nb,s,0,2,../x.mp4,\nc,s,0,2,/etc/x.mp4,\nd,s,0,2,x.mp4,\n../e,s,0,2,,\n"
    )
    found = catalogued(data, "table")
    assert found.clips.index.tolist() == ["d"]
    rules = found.ledger["rule"].dropna().to_dict()
    assert rules == {"a": "bad_times", "b": "unsafe_path", "c": "unsafe_path", "../e": "unsafe_id"}


def test_a_video_outside_of_the_data_is_not_looked_into(tmp_path, put, catalogued):
    data = put(tmp_path, "secret.mp4") / "data"
    data.mkdir()
    (data / "link.mp4").symlink_to(tmp_path / "secret.mp4")
    videos = ("../secret.mp4", str(tmp_path / "secret.mp4"), "a\x00b", "/", ".", "..", "link.mp4")
    lines = "".join(f"c{n},{video}\n" for n, video in enumerate(videos))
    (data / "clips.csv").write_text(f"clip_id,video\n{lines}")
    found = catalogued(data, "table")
    assert found.clips["video"].tolist() == ["link.mp4"]  # the user's own
    failed = found.ledger.drop("c6")
    assert (failed["rule"] == "unsafe_path").all() and len(failed) == 6
    assert "leads out of data_dir" in failed.loc["c0", "detail"]


def test_a_quotation_mark_that_nothing_closes_is_named_by_its_line(read):
    with pytest.raises(BadFile, match="begins in line 3: found unexpected end of data"):
        read('clip_id,source_id,end_s\na,s,3\n"b,s,3\nc,s,4\n')


@pytest.mark.parametrize(
    ("header", "found"),
    [
        ("id,source_id", "no column clip_id, but id"),
        ("clip_id,source_id,start,end", "a column start, expected start_s, or neither"),
        ("clip_id,source_id,end_s,Video", "a column Video, expected video, or neither"),
        ("Clip ID,source_id", "no column clip_id, but Clip ID"),
        ("clip_id,end_s", "no column video and no column source_id"),
        ("clip_id,sourceid", "no column video and no column source_id, but sourceid"),
    ],
)
def test_a_missing_column_stops_the_run_and_names_what_it_may_be(read, header, found):
    with pytest.raises(MissingColumn) as caught:
        read(f"{header}\na,b\n")
    assert f"found {found}" in str(caught.value)


def test_columns_that_are_not_used_are_named_once(read, caplog):
    with caplog.at_level(logging.INFO):
        read("clip_id,source_id,end_s,atributes,quality\na,s,1,male,5\nb,s,1,male,5\n")
    assert caplog.messages == [
        "clips.csv: column atributes is not used: is it attributes?",
        "clips.csv: columns not used: quality",
    ]


@pytest.mark.parametrize(
    ("content", "found"),
    [
        (b"", "an empty file"),
        (b"\n\n", "no header"),
        ("clip_id,source_id\n".encode("utf-16"), "UTF-16"),
        ("clip_id,source_id\na,b\nBj\xf6rk,s\n".encode("latin-1"), "a byte in line 3"),
        (b"<!doctype html><p>404", "an HTML page"),
        (b"version https://git-lfs.github.com/spec/v1\n", "a Git LFS pointer"),
        (b'clip_id,source_id\n"a,b\n', "unexpected end of data"),
        (b'clip_id,source_id\n"a"b,c\n', "expected after"),
        (b"clip_id,source_id,clip_id\na,b,c\n", "column clip_id 2 times"),
        (b"clip_id,source_id\na," + b"x" * 200_000 + b"\n", "field larger"),
    ],
)
def test_a_file_that_is_no_table_stops_the_run(read, content, found):
    with pytest.raises(BadFile) as caught:
        read(content)
    assert found in str(caught.value)


def test_no_file_and_no_parquet_stop_the_run(data, read):
    with pytest.raises(NoSuchFile, match=r"catalogue\.table\.file"):
        table.read(data, "clips.csv", Limits())
    for raw, file in ((b"PAR1 and then nothing", "clips.csv"), (b"clip_id\na\n", "clips.parquet")):
        with pytest.raises(BadFile, match="Parquet"):
            read(raw, file)


@pytest.mark.parametrize("separator", [";", "\t", ",", ", "])
def test_semicolons_tabs_and_a_byte_order_mark_are_read(read, separator):
    lines = (("clip_id", "source_id", "end_s", "actions"), ("a", "Bj\xf6rk", "1.5", '"nod;talk"'))
    text = "".join(separator.join(cells) + "\r\n" for cells in lines)
    (row,), bad = read(b"\xef\xbb\xbf" + text.encode())
    assert (row["clip_id"], row["source_id"], row["end_s"]) == ("a", "Bj\xf6rk", 1.5)
    assert [action["name"] for action in row["actions"]] == ["nod", "talk"] and bad == []


def test_the_clips_table_of_a_run_is_a_catalogue(data, catalogued):
    (data / "clips.csv").write_text(
        "clip_id,source_id,start_s,end_s,actions,emotion,attributes,texts\n"
        "a,s,1,4,smile@0-1;talk,sad,male,A man.|He talks.\n"
    )
    first = catalogued(data, "table").clips
    tables.write(tables.CLIPS, first.reset_index(), data / "clips.parquet")
    again = catalogued(data, "table", file="clips.parquet").clips
    for column in ("start_s", "end_s", "emotion", "actions", "emotions", "attributes", "texts"):
        assert again[column].astype(str).tolist() == first[column].astype(str).tolist()


NAMES = st.from_regex(r"[a-z][a-z0-9_]{0,8}", fullmatch=True)
IDS = st.text(st.characters(codec="utf-8", exclude_categories=("Z", "C")), min_size=1, max_size=8)
NUMBERS = st.floats(0, 1000, allow_nan=False).map(lambda number: round(number, 3))


@st.composite
def clips(draw):
    start, length = draw(NUMBERS), draw(st.floats(0.1, 100).map(lambda number: round(number, 3)))
    return {
        "clip_id": draw(IDS),
        "source_id": draw(IDS),
        "subject_id": draw(IDS | st.none()),
        "start_s": start,
        "end_s": start + length,
        "width": draw(st.none() | st.integers(1, 9999)),
        "emotion": draw(NAMES | st.none()),
        "attributes": draw(st.lists(NAMES, max_size=3)),
        "texts": draw(st.lists(IDS.filter(lambda text: "|" not in text), max_size=2)),
        "actions": [
            {"name": name, "start_s": 0.0, "end_s": round(length * share, 3), "uncertainty_s": None}
            for name, share in draw(st.lists(st.tuples(NAMES, st.floats(0.1, 1.0)), max_size=3))
            if round(length * share, 3) > 0
        ],
    }


@SMALL
@given(st.lists(clips(), max_size=4), st.sampled_from(",;\t"))
def test_what_is_written_is_read(read, written, separator):
    buffer = io.StringIO()
    sheet = csv.DictWriter(
        buffer,
        [*table.IDS[:2], "subject_id", "start_s", "end_s", "width", "emotion", *table.LISTS],
        delimiter=separator,
        quoting=csv.QUOTE_ALL,
    )
    sheet.writeheader()
    for clip in written:
        lists = {
            "attributes": ";".join(clip["attributes"]),
            "texts": "|".join(clip["texts"]),
            "actions": ";".join(
                f"{a['name']}@{a['start_s']}-{a['end_s']:.3f}" for a in clip["actions"]
            ),
        }
        sheet.writerow(clip | lists)
    rows, bad = read(buffer.getvalue())
    assert bad == []
    for row, clip in zip(rows, written, strict=True):
        for action in clip["actions"]:
            action["end_s"] = min(action["end_s"], row["end_s"] - row["start_s"])
        assert {key: row[key] for key in clip} == clip


@SMALL
@given(st.lists(st.lists(st.text(max_size=12), min_size=17, max_size=17), max_size=3))
def test_hostile_cells_are_bad_records_and_nothing_else(read, cells):
    buffer = io.StringIO()
    csv.writer(buffer).writerows([table.KNOWN, *cells])
    try:
        rows, bad = read(buffer.getvalue().encode(errors="surrogatepass"))
    except MimelineError:
        return
    assert len(rows) + len(bad) <= len(cells)
    assert all(isinstance(error, MimelineError) for _, error in bad)


VALUES = st.one_of(
    st.lists(st.none() | st.booleans(), min_size=2, max_size=2),
    st.lists(st.none() | st.integers(-(2**63), 2**63 - 1), min_size=2, max_size=2),
    st.lists(st.none() | st.floats(), min_size=2, max_size=2),
    st.lists(st.none() | st.text(max_size=8), min_size=2, max_size=2),
    st.lists(st.none() | st.binary(max_size=4), min_size=2, max_size=2),
    st.lists(st.lists(st.none() | st.text(max_size=4), max_size=2), min_size=2, max_size=2),
    st.lists(st.dates(), min_size=2, max_size=2),
)


@SMALL
@given(st.dictionaries(st.sampled_from(table.KNOWN), VALUES, max_size=8))
def test_hostile_parquet_columns_are_bad_records_and_nothing_else(read, columns):
    whole = {"clip_id": ["a", "b"], "source_id": ["s", "s"], "end_s": [2.0, 3.0]}
    try:
        rows, bad = read(whole | columns)
    except MimelineError:
        return
    assert len(rows) + len(bad) == 2
    assert all(isinstance(error, MimelineError) for _, error in bad)
