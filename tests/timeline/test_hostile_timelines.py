from fractions import Fraction

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from mimeline.errors import BadFile, MimelineError, NoSuchFile
from mimeline.timeline.files import FORMATS, format_of, lint, read, read_all, write
from mimeline.timeline.formats import text_file
from mimeline.timeline.timeline import Interval, Timeline

FPS = Fraction(25)
EVERY_FORMAT = pytest.mark.parametrize("form", FORMATS.values(), ids=FORMATS)
TIMELINE = Timeline(
    "clip",
    FPS,
    300,
    {
        "brow": [Interval("BrowUp", 10, 40, "left", "ticc", 3, 0.5)],
        "closure": [],
        "mouth": [Interval("Smile", 1, 7), Interval("SoftSmile", 7, 300)],
    },
)
BOMB = """<?xml version="1.0"?>
<!DOCTYPE lolz [<!ENTITY a "haha"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">
<!ENTITY c "&b;&b;&b;&b;&b;&b;&b;&b;&b;&b;"><!ENTITY d "&c;&c;&c;&c;&c;&c;&c;&c;&c;&c;">]>
<ANNOTATION_DOCUMENT>&d;</ANNOTATION_DOCUMENT>"""
STEALS = """<?xml version="1.0"?>
<!DOCTYPE a [<!ENTITY secret SYSTEM "file:///etc/passwd">]>
<ANNOTATION_DOCUMENT>&secret;</ANNOTATION_DOCUMENT>"""
CALLS = """<?xml version="1.0"?>
<!DOCTYPE a SYSTEM "http://127.0.0.1:9/a.dtd"><ANNOTATION_DOCUMENT/>"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("hostile")


@pytest.fixture(scope="module")
def good(folder):
    """The bytes of one good file of each format."""
    found = {}
    for form in FORMATS.values():
        write(TIMELINE, folder / f"good{form.suffixes[0]}")
        found[form.name] = (folder / f"good{form.suffixes[0]}").read_bytes()
    return found


def survives(path):
    """Reads the file in every way; only our own errors may come, each of one printable line."""
    for attempt in (read, read_all, lint):
        try:
            told = attempt(path, FPS, 300)
        except MimelineError as error:
            told = [error]
        if isinstance(told, list):
            for problem in told:
                assert "\n" not in str(problem) and not isinstance(problem, NoSuchFile)


@EVERY_FORMAT
@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_a_good_file_that_was_cut_or_overwritten_gives_a_timeline_or_our_error(
    folder, good, form, data
):
    content = good[form.name]
    start = data.draw(st.integers(0, len(content)))
    length = data.draw(st.sampled_from([0, 1, 2, 20, len(content)]))
    patch = data.draw(
        st.binary(max_size=12)
        | st.sampled_from(
            [b"\n\n", b'"', b"<", b"#", b"&", b"9" * 40, b"-1", b"1e99", b"\xff", b"\x00", b"\r"]
        )
    )
    path = folder / f"spoilt{form.suffixes[0]}"
    path.write_bytes(content[:start] + patch + content[start + length :])
    survives(path)


@EVERY_FORMAT
@settings(max_examples=40, deadline=None)
@given(text=st.text())
@example(text="\N{REPLACEMENT CHARACTER}")
@example(text="WEBVTT\n\n\n-->\n\n --> \n")
@example(text="#\n##\n###\n####")
@example(text='"ooTextFile""TextGrid"0 1<exists>1')
@example(text="{}")
@example(text="[{}, null, [[]], 1e999]")
def test_any_text_gives_a_timeline_or_our_error(folder, form, text):
    path = folder / f"any{form.suffixes[0]}"
    path.write_text(text, encoding="utf-8", errors="replace")
    survives(path)


@EVERY_FORMAT
@settings(max_examples=20, deadline=None)
@given(content=st.binary())
def test_any_bytes_give_a_timeline_or_our_error(folder, form, content):
    path = folder / f"bytes{form.suffixes[0]}"
    path.write_bytes(content)
    survives(path)


@settings(max_examples=60, deadline=None)
@given(
    cells=st.lists(
        st.lists(
            st.sampled_from(["a", "brow", "BrowUp", "3", "9", "", "left", "ticc", "0.5", "nan"])
            | st.text(max_size=5),
            max_size=10,
        ),
        max_size=5,
    )
)
def test_any_cells_give_timelines_or_our_error(folder, cells):
    path = folder / "cells.csv"
    header = "clip_id,track,action,start_frame,end_frame,side,source,cluster,confidence"
    rows = [",".join(row) for row in cells]
    path.write_text("\n".join([header, *rows]), encoding="utf-8", errors="replace")
    survives(path)


@pytest.mark.parametrize("content", [BOMB, STEALS, CALLS], ids=["bomb", "steals", "calls"])
def test_xml_with_a_document_type_is_refused_before_it_is_opened_up(folder, content):
    path = folder / "a.eaf"
    path.write_text(content)
    with pytest.raises(BadFile, match="a document type, which may hold entities.*ELAN writes no"):
        read(path)


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"<ANNOTATION_DOCUMENT>", "line 1, column 22: found the end of the file, before"),
        (b"<a>\n <b></a>", "line 2, column 7: found an element that is closed though another"),
        (b"<a/>", 'XML of "a", expected an ANNOTATION_DOCUMENT'),
        (b"PK\x03\x04\x00\x00", "line 1, column 3: found a character or a tag that XML"),
        (b'<?xml version="1.0" encoding="ducks"?><a/>', "found unknown encoding"),
        (b'<?xml version="1.0" encoding="utf-7"?><a/>', "XML of an ELAN file"),
        (b"<a>" * 200000, "line 1"),
        (
            "<!-- \u00e9 -->".encode("latin-1"),
            "line 1, column 6: found a character or a tag",
        ),
    ],
)
def test_what_is_no_elan_file_is_refused_at_its_place(folder, content, told):
    path = folder / "b.eaf"
    path.write_bytes(content)
    with pytest.raises(BadFile, match=told):
        read(path)


@EVERY_FORMAT
def test_a_file_of_gigabytes_is_refused_without_being_read(folder, form):
    path = folder / f"huge{form.suffixes[0]}"
    with open(path, "wb") as file:
        file.truncate(8 * 2**30)  # a hole: nothing is written
    try:
        with pytest.raises(BadFile, match="found 8192 MiB"):
            read(path, FPS, 300)
    finally:
        path.unlink()


def test_a_file_that_never_ends_is_read_up_to_the_limit(monkeypatch):
    with pytest.raises(BadFile, match="at most 0 MiB"):
        text_file.read_bytes("/dev/zero", "a file", most_bytes=100)


@pytest.mark.parametrize("form", ["csv", "webvtt", "praat", "stmc", "json"])
def test_text_in_another_encoding_is_refused_at_its_byte(folder, good, form):
    path = folder / f"latin{FORMATS[form].suffixes[0]}"
    path.write_bytes(good[form] + "é".encode("latin-1"))
    with pytest.raises(BadFile, match=f"byte {len(good[form])}: found bytes that are no UTF-8"):
        read(path, FPS, 300)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("voice.vtt", "WEBVTT\n\n00:00.400 --> 00:01.600\n<v " + " " * 300_000),
        ("brackets.TextGrid", '"ooTextFile" "TextGrid" 0 3 <exists> 1 ' + "[" * 300_000),
    ],
)
def test_a_text_made_to_take_hours_is_refused(folder, name, text):
    (folder / name).write_text(text)
    with pytest.raises(BadFile):
        read(folder / name, FPS, 75)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("long.vtt", f'WEBVTT\n\nNOTE mimeline {{"fps": "25", "frames": 1{"0" * 400}}}\n'),
        (
            "long.TextGrid",
            '"ooTextFile" "TextGrid" 0 1e99 <exists> 1 "IntervalTier" "brow" 0 1e99 1 0 1e99 ""',
        ),
    ],
)
def test_a_length_that_no_clip_has_is_refused(folder, name, text):
    (folder / name).write_text(text)
    with pytest.raises(BadFile, match="found a length of .* frames, expected as many as the clip"):
        read(folder / name, None if name.endswith("vtt") else FPS)


@EVERY_FORMAT
def test_a_file_that_is_not_there_is_said_so(folder, form):
    for attempt in (read, lint):
        with pytest.raises(NoSuchFile, match="no such file"):
            attempt(folder / f"nowhere{form.suffixes[0]}", FPS, 300)


def test_a_folder_is_no_file(folder):
    (folder / "deep.eaf").mkdir()
    with pytest.raises(BadFile, match="deep.eaf: found"):
        read(folder / "deep.eaf")
    with pytest.raises(BadFile, match="deep.eaf: found"):
        write(TIMELINE, folder / "deep.eaf")


@pytest.mark.parametrize("name", ["a\nb", "a#b", "a<b>&c", "a\"b'c", "\x1b[31mred", "=1+1", "-rf"])
def test_a_tier_of_any_name_is_told_in_one_line(folder, name):
    path = folder / "named.eaf"
    write(TIMELINE, path)
    escaped = "".join(f"&#{ord(c)};" for c in name)
    text = path.read_text().replace('TIER_ID="mouth"', f'TIER_ID="{escaped}"')
    path.write_text(text)
    with pytest.raises(BadFile) as error:
        read(path)
    assert "\x1b" not in str(error.value) and "\n" not in str(error.value)


@EVERY_FORMAT
def test_a_clip_of_a_hostile_name_comes_back_or_is_refused(folder, form):
    for name in ["a\nb", "a#b", "a<b>&c", "a\"b'c", "a --> b", "=1+1", "'x", " a ", "a\r", "é"]:
        path = folder / f"hostile{form.suffixes[0]}"
        timeline = Timeline(name, FPS, 9, {"brow": [Interval("BrowUp", 2, 5)]})
        try:
            lost = write(timeline, path)
        except BadFile as error:
            assert form.name in ("elan", "csv") and name == "a\r", error
            continue
        told = {"fps": FPS, "n_frames": 9}
        assert read(path, **told, clip_id=name if "clip" in lost else None) == timeline


def test_a_write_that_fails_leaves_what_stood_there(folder):
    path = folder / "kept.eaf"
    write(TIMELINE, path)
    before = path.read_bytes()
    with pytest.raises(BadFile):
        write(Timeline("\x00", FPS, 9, {}), path)
    assert path.read_bytes() == before
    assert list(folder.glob("*.tmp")) == []


@pytest.mark.parametrize(
    ("name", "format", "told"),
    [
        ("a.srt", None, r'ends in ".srt", expected one that ends in .json, .csv'),
        ("a", None, "a name without an ending"),
        ("a.vtt", "elna", 'format "elna".*Did you mean elan'),
        ("a.vtt", "zzz", "Say one of these"),
    ],
)
def test_a_format_that_is_not_known_is_refused_with_those_that_are(name, format, told):
    with pytest.raises(BadFile, match=told):
        format_of(name, format)


def test_suffixes_may_be_of_any_case_and_a_format_may_be_said():
    assert format_of("a.TEXTGRID").name == "praat"
    assert format_of("a.xml", "elan").name == "elan"
