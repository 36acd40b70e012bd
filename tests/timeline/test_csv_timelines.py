from fractions import Fraction

import pandas as pd
import pytest

from mimeline import tables
from mimeline.errors import BadFile
from mimeline.timeline.files import lint, read, read_all, write_all
from mimeline.timeline.formats.csv_file import COLUMNS
from mimeline.timeline.timeline import Interval, Timeline

HEADER = "clip_id,track,action,start_frame,end_frame,side,source,cluster,confidence\n"
FPS = Fraction(25)


@pytest.fixture
def file(tmp_path):
    def made(text, encoding="utf-8"):
        path = tmp_path / "clips.csv"
        path.write_text(text, encoding=encoding)
        return path

    return made


def test_its_columns_are_those_of_the_intervals_table():
    assert tuple(tables.INTERVALS.schema.names) == COLUMNS


def test_pandas_reads_it_as_an_intervals_table(tmp_path):
    drawn = [
        Timeline("-a", FPS, 90, {"brow": [Interval("BrowUp", 0, 9, "left", "ticc", 3, 0.5)]}),
        Timeline("b", FPS, 90, {"mouth": [Interval("Smile", 7, 80)]}),
    ]
    write_all(drawn, tmp_path / "a.csv")
    tables.write(tables.INTERVALS, pd.read_csv(tmp_path / "a.csv"), tmp_path / "a.parquet")
    rows = tables.read(tables.INTERVALS, tmp_path / "a.parquet")
    assert rows.clip_id.tolist() == ["-a", "b"] and rows.cluster.tolist() == [3, pd.NA]


def test_an_intervals_table_that_pandas_wrote_is_read(tmp_path):
    rows = pd.DataFrame(
        [("a", "lid", "EyeSquint", 3, 9, None, "ticc", 4, 0.25)] * 1
        + [("a", "brow", "BrowUp", 3, 9, "right", "human", None, None)],
        columns=COLUMNS,
    )
    rows.to_csv(tmp_path / "a.csv", index=False)  # cluster becomes 4.0
    (timeline,) = read_all(tmp_path / "a.csv", FPS, 30)
    assert timeline == Timeline(
        "a",
        FPS,
        30,
        {
            "brow": [Interval("BrowUp", 3, 9, "right")],
            "lid": [Interval("EyeSquint", 3, 9, None, "ticc", 4, 0.25)],
        },
    )


def test_the_last_columns_may_lack_and_all_may_be_in_any_order(file):
    path = file("action,track,clip_id,end_frame,start_frame\nSmile,mouth,a,9,3\n")
    assert read(path, FPS, 30).tracks == {"mouth": (Interval("Smile", 3, 9),)}


def test_a_spreadsheets_byte_order_mark_is_no_part_of_the_first_column(file):
    path = file(HEADER + "a,mouth,Smile,3,9,,,,\n", "utf-8-sig")
    assert read(path, FPS, 30).clip_id == "a"


def test_rows_that_a_spreadsheet_emptied_are_none(file):
    path = file(HEADER + ",,,,,,,,\na,mouth,Smile,3,9,,,,\n,,,,,,,,\n")
    assert read(path, FPS, 30).tracks == {"mouth": (Interval("Smile", 3, 9),)}


@pytest.mark.parametrize(
    ("name", "row"),
    [("clip.csv", HEADER + "clip,lid,Neutral,0,30,,,,\n"), ("clip.txt", "Neutral # 0 # 1.2 # lid")],
)
def test_formats_of_intervals_alone_have_a_neutral_track_by_a_row_that_says_so(tmp_path, name, row):
    (tmp_path / name).write_text(row)
    assert read(tmp_path / name, FPS, 30).tracks == {"lid": ()}


def test_frames_per_second_and_frames_have_to_be_said(file):
    path = file(HEADER + "a,mouth,Smile,3,9,,,,\n")
    with pytest.raises(BadFile, match="--fps RATE, such as 25.*1 more: mimeline timeline lint"):
        read(path)
    with pytest.raises(BadFile, match="no length.*--frames N"):
        read(path, FPS)


def test_each_clip_has_its_own_length(file):
    path = file(HEADER + "a,mouth,Smile,3,9,,,,\nb,mouth,Smile,3,9,,,,\n")
    a, b = read_all(path, FPS, {"a": 20, "b": 30})
    assert (a.n_frames, b.n_frames) == (20, 30)
    with pytest.raises(BadFile, match="clip b: found no length"):
        read_all(path, FPS, {"a": 20})
    assert [problem.place for problem in lint(path)] == ["", ""]  # told once for both


@pytest.mark.parametrize(
    ("row", "place", "told"),
    [
        ("a,mouth,Smile,x,9,,,,", "line 2, column start_frame", "whole number"),
        ("a,mouth,Smile,,9,,,,", "line 2, column start_frame", "an empty cell"),
        ("a,mouth,Smile,3.5,9,,,,", "line 2, column start_frame", "whole number"),
        ("a,mouth,Smile,3,9,both,,,", "line 2, column side", "left, right, or nothing"),
        ("a,mouth,Smile,3,9,,machine,,", "line 2, column source", "human"),
        ("a,mouth,Smile,3,9,,,-2,", "line 2, column cluster", "0 or more"),
        ("a,mouth,Smile,3,9,,,,nan", "line 2, column confidence", "share"),
        ("a,mouth,Smile,3,9,,,,7", "line 2, column confidence", "share"),
        ("a,mouth,Smile,3,9", "line 2", "5 cells"),
        (",mouth,Smile,3,9,,,,", "line 2", "clip_id"),
        ("a,mouth,Smle,3,9,,,,", "line 2", "Did you mean Smile"),
        ("a,mouht,Smile,3,9,,,,", "line 2", "Did you mean mouth"),
        ("a,brow,Smile,3,9,,,,", "line 2", "Move it to mouth"),
        ("a,mouth,Smile,9,3,,,,", "line 2", "reversed"),
        ("a,mouth,Smile,3,3,,,,", "line 2", "empty"),
        ("a,mouth,Smile,-3,9,,,,", "line 2", "within the clip"),
        ("a,mouth,Smile,3,31,,,,", "line 2", "frames 0 to 30"),
        ('a,mouth,"Smile,3,9,,,,', "line 2", "quotes"),
    ],
)
def test_a_row_that_is_wrong_is_refused_at_its_place(file, row, place, told):
    with pytest.raises(BadFile) as error:
        read(file(HEADER + row + "\n"), FPS, 30)
    assert error.value.place == place and told in str(error.value)


@pytest.mark.parametrize(
    ("header", "told"),
    [
        (HEADER.replace(",", ";"), "not semicolons"),
        (
            HEADER.replace("start_frame", "start_fram"),
            "Did you mean start_frame by column",
        ),
        (HEADER.replace("track,", ""), "no column track"),
        (HEADER.replace("side", "track"), 'column "track"'),
        ("", "no column clip_id"),
        ("just some text\n", "no column clip_id"),
    ],
)
def test_another_header_is_refused(file, header, told):
    with pytest.raises(BadFile, match=told):
        read_all(file(header), FPS, 30)


def test_overlap_within_a_track_is_an_error_and_between_sides_is_none(file):
    rows = "a,brow,BrowUp,3,9,left,,,\na,brow,BrowDown,5,12,right,,,\n"
    assert lint(file(HEADER + rows), FPS, 30) == []
    (problem,) = lint(file(HEADER + rows + "a,brow,BrowUp,8,11,,,,\n"), FPS, 30)
    assert problem.place == "line 4" and "a start at 12 or later" in problem.expected
