from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from mimeline.errors import BadFile, MissingColumn, NoSuchFile
from mimeline.tracking.formats.columns import (
    all_origins,
    angles,
    by_channel,
    expressions,
    header_of,
    numbers,
    read_columns,
)

HEADER = "jawOpen,mouthLeft,note"


@pytest.fixture
def file(tmp_path):
    def file(content: str | bytes):
        path = tmp_path / "take.csv"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return file


def values(path, bad_values="fail", **keys):
    table = read_columns(path)
    return numbers(table, ["jawOpen", "mouthLeft"], path, bad_values, **keys)


@pytest.mark.parametrize(
    "content",
    [
        f"{HEADER}\n0.25,1,a\n0.5,0,b\n",
        f"{HEADER}\r\n0.25,1,a\r\n0.5,0,b\r\n",
        f"{HEADER}\r\r\n0.25,1,a\r\r\n0.5,0,b\r\r\n",
        f"\ufeff{HEADER}\n0.25,1,a\n0.5,0,b",
        f"\n{HEADER}\n\n0.25,1,a\n\n0.5,0,b\n\n",
        f"{HEADER},\n0.25,1,a,\n0.5,0,b,\n",
        f"{HEADER},,\n0.25,1,a,,\n0.5,0,b,,\n",
        f"{HEADER}\n0.25,1,a,\n0.5,0,b,\n",
        f"{HEADER}\n0.25,1,a\n0.5,0,b,,\n",
        f",{HEADER}\n0,0.25,1,a\n1,0.5,0,b\n",
        '"jawOpen","mouthLeft","note"\n"0.25","1","a"\n"0.5","0","b"\n',
        'jawOpen, "mouthLeft" , note\n 0.25, 1 ,a\n 0.5 ,+0, b\n',
    ],
    ids=[
        "plain",
        "CRLF",
        "CRCRLF",
        "BOM",
        "blank lines",
        "nameless last column",
        "nameless last columns",
        "commas at the end of rows",
        "commas at the end of a row",
        "nameless first column",
        "quoted",
        "spaces",
    ],
)
def test_every_way_of_writing_a_table_gives_the_same_numbers(file, content):
    path = file(content)
    table = read_columns(path)
    assert table.columns.tolist() == HEADER.split(",")
    assert header_of(path) - {""} == (frozenset() if content[0] == "\n" else {*HEADER.split(",")})
    assert values(path)[0].to_numpy().tolist() == [[0.25, 1], [0.5, 0]]


@pytest.mark.parametrize("cell", ["n/a", "nan", "", "inf", "1e999", "True", "0x1", "1_0", "1 0"])
@pytest.mark.parametrize("rest", ["\n", "\n\n", ",\n", ',"two\nlines"\n'])
def test_a_cell_that_is_no_number_is_found_where_it_stands(file, cell, rest):
    path = file(f"jawOpen,mouthLeft,note\n0,0{rest}1,1{rest}0,{cell},\n2,2,\n")
    at = 2 + 2 * rest.count("\n")
    found = "inf" if cell in ("inf", "1e999") else repr(cell)
    with pytest.raises(BadFile, match=f"line {at}, column mouthLeft: found {found}, expected"):
        values(path)
    told, bad = values(path, "mask")
    assert bad.tolist() == [False, False, True, False]
    assert told["mouthLeft"].isna().tolist() == bad.tolist()
    assert told["jawOpen"].tolist() == [0, 1, 0, 2]
    _, bad = values(path, "mask", blank_ok=True)
    assert bad[2] == (cell != "")


def test_a_column_that_is_to_stay_text_stays_as_it_stands(file):
    table = read_columns(file("clip,jawOpen\n007,1\n08,2\n"), text=("clip",))
    assert table["clip"].tolist() == ["007", "08"]


def test_a_bad_cell_deep_in_a_large_file_is_found(file):
    rows = ["0.5,0.5,x"] * 60_000
    rows[50_000] = "0.5,oops,x"
    with pytest.raises(BadFile, match="line 50002, column mouthLeft: found 'oops'"):
        values(file("\n".join([HEADER, *rows])))


def test_a_row_with_too_many_cells_is_refused_and_one_with_too_few_is_bad(file):
    with pytest.raises(BadFile, match=r"line 4: found 4 cells, expected 3.*"):
        values(file(f"{HEADER}\n0,0,a\n\n0,0,a,9\n"))
    with pytest.raises(BadFile, match=r"line 2: found 5 cells, expected 3.*"):
        values(file(f"{HEADER}\n0,0,a,,9\n0,0,a\n"))
    with pytest.raises(BadFile, match="line 3: found 1 cells, expected 3.*delete the line"):
        values(file(f"{HEADER}\n0,0,a\n1\n"), blank_ok=True)


def test_a_row_that_is_cut_off_is_bad_from_its_last_cell_on(file):
    path = file("note,jawOpen,mouthLeft,x\n\na,0,0,1\n   \nb,1,0.\n\nc,1,1,1\nd\n")
    told, bad = values(path, "mask", blank_ok=True)
    assert bad.tolist() == [False, True, False, True]
    assert told["jawOpen"].tolist()[:3] == [0, 1, 1]
    assert told["mouthLeft"].isna().tolist() == bad.tolist()
    with pytest.raises(BadFile, match="found 3 cells, expected 4"):
        values(path, blank_ok=True)


@pytest.mark.parametrize("rows", ["0,1\n1,0\n", "0,1,,\n1,0\n", "0,1\n1,\n"])
def test_rows_that_all_lack_the_last_columns_are_not_cut_off(file, rows):
    _, bad = values(file(f"jawOpen,mouthLeft,note,more\n{rows}"), blank_ok=True)
    assert not bad.any()


def test_empty_cells_may_be_fine_in_some_cells_and_in_columns_without_a_number(file):
    path = file("jawOpen,mouthLeft,note\n,,a\n1,,b\n,,c\n")
    _, bad = values(path, "mask", blank_ok=np.array([[True], [False], [False]]))
    assert bad.tolist() == [False, False, True]


def test_a_misspelt_column_is_named_where_its_channel_is_missed():
    origins = all_origins(["JawOpne", "cheekPuff", "Timecode"], {})
    assert origins["jawOpen"].text == "the file has no such column (it has JawOpne)"
    assert origins["tongueOut"].text == "the file has no such column"


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\n\n",
        b"\xff\xfej\x00a\x00",
        b"jawOpen,note\n1,\xff\n",
        b'jawOpen\n"1\n',
        b"\x00\x01\x02" * 50,
        b"jawOpen,mouthLeft\n" + b"9" * 200_000 + b",x\n1,2,3\n",
    ],
)
def test_what_is_no_table_is_refused(file, content):
    with pytest.raises(BadFile):
        values(file(content))


def test_a_table_with_other_separators_or_no_names_says_so(file):
    with pytest.raises(BadFile, match="line 1: found columns separated by ';'"):
        read_columns(file("jawOpen;mouthLeft\n0,5;1\n"))
    with pytest.raises(BadFile, match="a header with channel names"):
        read_columns(file("0.5,0.25\n0.5,0.25\n"))
    with pytest.raises(BadFile, match="column jawOpen twice"):
        read_columns(file("jawOpen,JawOpen\n0,1\n"))
    with pytest.raises(NoSuchFile):
        read_columns(file("").with_name("nothing.csv"))


def test_asked_for_columns_are_found_in_any_case_and_missed_by_name(file):
    path = file("FRAME,jawopen\n1,0.5\n")
    assert read_columns(path, needed=("Frame",))["Frame"].tolist() == [1]
    with pytest.raises(MissingColumn, match="expected score"):
        read_columns(path, needed=("frame", "score"))
    with pytest.raises(BadFile, match="column Frame twice"):
        read_columns(file("FRAME,frame\n1,0.5\n"), needed=("Frame",))


def test_a_coefficient_or_an_angle_out_of_range_is_found_where_it_stands(file):
    path = file("jawOpen,mouthLeft,note\n0,0\n\n0,45\n")
    told, _ = values(path)
    with pytest.raises(BadFile, match="line 4, column mouthLeft: found 45"):
        expressions(told, path)
    with pytest.raises(BadFile, match="line 4, column mouthLeft: found an angle of 45 in radians"):
        angles(told, "radians", path, "Turn back.")
    assert angles(told, "degrees", path, "")["mouthLeft"].iloc[1] == pytest.approx(np.pi / 4)


def test_a_channel_of_two_columns_is_their_mean_and_says_what_it_lacks():
    signs = {"L": ("gaze_left", -1.0), "R": ("gaze_left", -1.0), "U": ("gaze_up", 1.0)}
    radians = pd.DataFrame({"L": [0.1, 0.2], "R": [0.3, np.nan], "U": [np.nan, np.nan]})
    channels, origins = by_channel(radians, signs)
    np.testing.assert_allclose(channels["gaze_left"], [-0.2, np.nan])
    assert channels.columns.tolist() == ["gaze_left"]
    assert origins["gaze_left"].text == "mean of columns -L and -R"
    assert origins["gaze_up"].text == "column U is 0 or empty throughout"
    assert "no column R" in by_channel(radians[["L", "U"]], signs)[1]["gaze_left"].text
    everything = all_origins(["jaw_open", "JawOpen"], origins)
    assert everything["jawOpen"].text == "column JawOpen"
    assert not everything["tongueOut"].measured
    assert everything["gaze_left"].measured


def test_what_is_too_large_or_without_an_end_is_refused_unread(file):
    path = file(f"{HEADER}\n0,0,a\n")
    with open(path, "r+b") as written:
        written.truncate(2**31)  # a sparse file: no byte is written
    with pytest.raises(BadFile, match="found 2048 MiB, expected at most 1024 MiB"):
        read_columns(path)
    with pytest.raises(BadFile, match="no plain file"):
        read_columns(Path("/dev/zero"))


def test_a_large_file_is_not_taken_row_by_row(file):
    wide = b"0," + b" " * 2**20 + b"0,a,9\n"
    path = file(HEADER.encode() + b"\n" + wide * 65)
    with pytest.raises(BadFile, match="found 65 MiB, expected at most 64 MiB.*last column"):
        read_columns(path)


@pytest.mark.parametrize("rest", ["", ","])
def test_more_rows_than_a_take_may_have_are_refused(file, rest, monkeypatch):
    monkeypatch.setattr("mimeline.tracking.formats.columns.MOST_ROWS", 3)
    assert len(read_columns(file(f"{HEADER}\n" + f"0,0,a{rest}\n" * 3))) == 3
    with pytest.raises(BadFile, match="more than 3 rows"):
        read_columns(file(f"{HEADER}\n" + f"0,0,a{rest}\n" * 4))
