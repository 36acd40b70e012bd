from fractions import Fraction

import pytest

from mimeline.errors import BadFile
from mimeline.timeline.files import lint, read, write
from mimeline.timeline.timeline import Interval, Timeline

FPS = Fraction(25)


@pytest.fixture
def file(tmp_path):
    def made(text):
        path = tmp_path / "clip.vtt"
        path.write_text(text, encoding="utf-8", newline="")
        return path

    return made


def test_each_interval_is_a_cue_that_its_track_speaks(tmp_path):
    brow = [Interval("BrowUp", 10, 40, "left"), Interval("BrowDown", 3700 * 25, 3701 * 25)]
    timeline = Timeline("a", FPS, 4000 * 25, {"brow": brow, "lid": []})
    write(timeline, tmp_path / "a.vtt")
    assert (tmp_path / "a.vtt").read_text() == (
        "WEBVTT\n\n"
        'NOTE mimeline {"clip": "a", "fps": "25", "frames": 100000, "tracks": ["brow", "lid"]}\n\n'
        "00:00:00.400 --> 00:00:01.600\n<v brow left>BrowUp</v>\n\n"
        "01:01:40.000 --> 01:01:41.000\n<v brow>BrowDown</v>\n"
    )
    assert read(tmp_path / "a.vtt") == timeline


def test_a_name_with_an_arrow_ends_no_note(tmp_path):
    timeline = Timeline("a --> b\n\nWEBVTT", FPS, 9, {"brow": [Interval("BrowUp", 1, 3)]})
    write(timeline, tmp_path / "a.vtt")
    assert "a -->" not in (tmp_path / "a.vtt").read_text()
    assert read(tmp_path / "a.vtt") == timeline


@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
def test_a_foreign_file_with_all_that_webvtt_has_is_read(file, newline):
    text = """\ufeffWEBVTT - by hand
Kind: metadata

STYLE
::cue(v) { color: red }

NOTE
a remark
over two lines

intro
00:00.400 --> 00:01.600 align:start line:0
<v.loud brow>BrowUp
<v mouth_left>Smile</v>

1
00:02.000 --> 00:02.400
<b>EyeClose</b>
"""
    assert read(file(text.replace("\n", newline)), FPS, 75).tracks == {
        "brow": (Interval("BrowUp", 10, 40),),
        "closure": (Interval("EyeClose", 50, 60),),
        "mouth": (Interval("Smile", 10, 40, "left"),),
    }


def test_what_others_say_is_left_out_with_a_warning(file):
    text = "WEBVTT\n\n00:00.400 --> 00:01.600\n<v Anna>Hello &lt;there&gt;\n<v brow>BrowUp\n"
    assert list(read(file(text), FPS, 75).tracks) == ["brow"]
    (problem,) = lint(file(text), FPS, 75)
    assert problem.severity == "warning" and problem.place == 'voice "Anna"'


@pytest.mark.parametrize(
    ("cue", "told"),
    [
        ("00:00.400 --> 00:01.600\nHello", 'line 3: found action "Hello"'),
        ("00:00.400 --> 00:01.600\n<v brow>BrowsUp", "Did you mean BrowUp"),
        ("00:00.400 -> 00:01.600\n<v brow>BrowUp", 'line 3: found "00:00.400 ->'),
        ("00:00,400 --> 00:01,600\n<v brow>BrowUp", "expected a cue"),
        ("00:00.400 --> 00:61.600\n<v brow>BrowUp", "expected a cue"),
        ("<v brow>BrowUp", "expected a cue"),
        ("00:01.600 --> 00:00.400\n<v brow>BrowUp", "reversed"),
        ("NOTE mimeline {", 'found "{", expected a note like'),
        ('NOTE mimeline {"fps": "x"}', "expected a note like"),
        ('NOTE mimeline {"fps": 29.97}', "expected a note like"),
        ('NOTE mimeline {"frames": -3}', "expected a note like"),
        ('NOTE mimeline {"tracks": [3]}', "expected a note like"),
        ("NOTE mimeline [" + "[" * 99999, "expected a note like"),
        ('NOTE mimeline {"tracks": ["bro"]}', 'track "bro".*Did you mean brow'),
    ],
)
def test_a_cue_or_note_that_is_wrong_is_refused(file, cue, told):
    with pytest.raises(BadFile, match=told):
        read(file(f"WEBVTT\n\n{cue}\n"), FPS, 75)


def test_the_rate_of_a_note_may_be_a_whole_number(file):
    text = 'WEBVTT\n\nNOTE mimeline {"fps": 30, "frames": 75}\n'
    assert read(file(text)).fps == 30


def test_a_cue_right_below_the_first_line_is_not_lost(file):
    text = "WEBVTT\n00:00.400 --> 00:01.600\n<v brow>BrowUp\n"
    assert read(file(text), FPS, 75).tracks == {"brow": (Interval("BrowUp", 10, 40),)}


@pytest.mark.parametrize(
    "between",
    [
        "\n",
        "\n\nNOTE\na remark\nof lines\n",
        "\n\nNOTE of a --> b\n\n",
        "\n\n",
        "\n\nNOTE a remark\n",
        '\n\nNOTE mimeline {"frames": 75}\n',
    ],
)
def test_a_cue_is_read_where_a_browser_reads_one_whatever_stands_right_above_it(file, between):
    first = "WEBVTT\n\n00:00.400 --> 00:01.600\n<v brow>BrowUp"
    text = f"{first}{between}00:01.800-->00:02.000\n<v brow>BrowDown\n"
    assert read(file(text), FPS, 75).tracks == {
        "brow": (Interval("BrowUp", 10, 40), Interval("BrowDown", 45, 50))
    }


def test_a_cue_of_nothing_is_no_interval(file):
    assert read(file("WEBVTT\n\n00:00.400 --> 00:01.600\n"), FPS, 75).tracks == {}


@pytest.mark.parametrize("text", ["", "1\n00:00:00,400 --> 00:00:01,600\nhi\n", "WEBVTTX\n"])
def test_what_does_not_begin_with_webvtt_is_refused(file, text):
    with pytest.raises(BadFile, match="line 1: .*expected WEBVTT.*SubRip"):
        read(file(text), FPS, 75)
