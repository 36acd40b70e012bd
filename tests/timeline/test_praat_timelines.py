from fractions import Fraction

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from praatio import textgrid
from praatio.utilities.constants import Interval as PraatInterval
from praatio.utilities.constants import Point

from mimeline.errors import BadFile
from mimeline.timeline.files import lint, read, write
from mimeline.timeline.timeline import Interval, Timeline

from .drawn import RATES, timelines

FPS = Fraction(25)
SHORT = """File type = "ooTextFile"
Object class = "TextGrid"

0
3
<exists>
2
"IntervalTier"
"brow"
0
3
3
0
0.4
""
0.4
2
"BrowUp"
2
3
""
"IntervalTier"
"mouth left"
0
3
1
0
3
""
"""
LONG = """File type = "ooTextFile"
Object class = "TextGrid"

xmin = 0
xmax = 3
tiers? <exists>
size = 1
item []:
    item [1]:
        class = "IntervalTier"
        name = "brow"
        xmin = 0
        xmax = 3
        intervals: size = 2
        intervals [1]:
            xmin = 0
            xmax = 0.4
            text = "BrowUp" ! a remark, as Praat allows
        intervals [2]:
            xmin = 0.4
            xmax = 3
            text = ""
"""


@pytest.fixture
def file(tmp_path):
    def made(text, encoding="utf-8"):
        path = tmp_path / "clip.TextGrid"
        path.write_bytes(text if isinstance(text, bytes) else text.encode(encoding))
        return path

    return made


@settings(max_examples=20, deadline=None)
@given(data=st.data())
def test_praatio_reads_the_same_intervals(tmp_path_factory, data):
    timeline = data.draw(timelines(data.draw(st.sampled_from(RATES))))
    assume(timeline.tracks)  # praatio reads no TextGrid without a tier
    path = tmp_path_factory.getbasetemp() / "praatio.TextGrid"
    write(timeline, path)
    grid = textgrid.openTextgrid(str(path), includeEmptyIntervals=False)
    found = [(name, *entry) for name in grid.tierNames for entry in grid.getTier(name).entries]
    assert sorted(found) == sorted(
        (
            f"{interval.track} {interval.side}" if interval.side else interval.track,
            float(interval.start / timeline.fps),
            float(interval.end / timeline.fps),
            interval.action,
        )
        for interval in timeline
    )
    assert {name.split()[0] for name in grid.tierNames} == set(timeline.tracks)
    assert grid.maxTimestamp == timeline.seconds


@pytest.mark.parametrize("form", ["short_textgrid", "long_textgrid"])
def test_a_file_that_praatio_saves_again_is_the_same_timeline(tmp_path, form):
    fps = Fraction(30000, 1001)
    brow = [Interval("BrowUp", 10, 40, "left"), Interval("BrowUp", 20, 60, "right")]
    mouth = [Interval("Smile", 1, 7), Interval("SoftSmile", 7, 300)]
    timeline = Timeline("b", fps, 300, {"brow": brow, "closure": [], "mouth": mouth})
    write(timeline, tmp_path / "a.TextGrid")
    grid = textgrid.openTextgrid(str(tmp_path / "a.TextGrid"), includeEmptyIntervals=True)
    grid.save(str(tmp_path / "b.TextGrid"), format=form, includeBlankSpaces=True)
    assert read(tmp_path / "b.TextGrid", fps) == timeline


def test_a_file_that_praatio_made_is_read(tmp_path):
    grid = textgrid.Textgrid()
    entries = [PraatInterval(0.4, 2.0, "BrowUp"), PraatInterval(2.0, 2.6, "BrowDown")]
    grid.addTier(textgrid.IntervalTier("brow", entries, 0, 3))
    grid.addTier(textgrid.PointTier("clicks", [Point(0.3, "click")], 0, 3))
    grid.save(str(tmp_path / "a.TextGrid"), format="long_textgrid", includeBlankSpaces=True)
    assert read(tmp_path / "a.TextGrid", FPS) == Timeline(
        "a", FPS, 75, {"brow": [Interval("BrowUp", 10, 50), Interval("BrowDown", 50, 65)]}
    )


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_the_short_form_is_read_in_every_encoding_that_praat_writes(file, encoding, newline):
    path = file(SHORT.replace("\n", newline), encoding)
    assert read(path, FPS) == Timeline(
        "clip", FPS, 75, {"brow": [Interval("BrowUp", 10, 50)], "mouth": []}
    )


def test_the_older_short_header_and_big_endian_are_read(file):
    older = SHORT.replace("ooTextFile", "ooTextFile short").replace("Object class = ", "")
    path = file(b"\xfe\xff" + older.encode("utf-16-be"))
    assert read(path, FPS).tracks["brow"] == (Interval("BrowUp", 10, 50),)


def test_the_long_form_may_hold_remarks(file):
    assert read(file(LONG), FPS).tracks == {"brow": (Interval("BrowUp", 0, 10),)}


def test_the_length_is_told_in_seconds_and_the_rate_has_to_be_said(file):
    with pytest.raises(BadFile, match="no frame rate.*--fps RATE"):
        read(file(LONG))
    assert read(file(LONG), Fraction(30)).n_frames == 90


def test_sound_may_last_a_little_longer_than_its_picture(file):
    path = file(LONG.replace("xmax = 3", "xmax = 3.0239"))
    assert read(path, FPS, 75).n_frames == 75
    (problem,) = lint(path, FPS)
    assert problem.severity == "warning" and "taken for 76 frames" in problem.remedy
    with pytest.raises(BadFile, match="a length of 3.024 s, expected 90 frames, as you said"):
        read(path, FPS, 90)


def test_an_action_that_lasts_to_the_end_of_the_sound_lasts_to_that_of_the_clip(file):
    path = file(LONG.replace("xmax = 3", "xmax = 3.0239").replace('text = ""', 'text = "BrowDown"'))
    assert read(path, FPS, 75).tracks["brow"][-1] == Interval("BrowDown", 10, 75)


def test_a_point_tier_of_actions_says_that_it_is_one(file):
    points = LONG.replace("IntervalTier", "TextTier").replace("            xmax = 0.4\n", "")
    points = points.replace("            xmin = 0.4\n            xmax = 3\n", "  number = 2\n")
    with pytest.raises(BadFile, match="found a point tier, expected an interval tier"):
        read(file(points), FPS)


def test_names_of_tiers_may_hold_quotes_and_foreign_tiers_are_left_out(file):
    path = file(SHORT.replace('"mouth left"', '"say ""ah"""'))
    assert list(read(path, FPS).tracks) == ["brow"]


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("ooTextFile", "TextFile", 'found "TextFile"'),
        ('"TextGrid"', '"PitchTier"', 'an object of "PitchTier"'),
        ("xmin = 0\nxmax = 3\n", "xmin = 1\nxmax = 3\n", "a start at 1.0 s.*Shift to zero"),
        ('"BrowUp"', '"BrowUp', "closing quote|expected a"),
        ("xmax = 0.4", "xmax = soon", 'line 18: found text "BrowUp", expected a number'),
        ("xmax = 0.4", "xmax = 1e999999", "a time in seconds"),
        ("size = 2", "size = 3", "the end of the file"),
        ("size = 1", "size = 2", "the end of the file"),
        ("size = 2", "size = -2", "how many follow"),
        ('"BrowUp"', '"BrowUpp"', "Did you mean BrowUp"),
        ('"brow"', '"borw"', "Did you mean brow"),
        ("xmax = 0.4", "xmax = 0.01", "lasts 10.0 ms, expected at least a frame: 40.0 ms"),
        ("xmax = 0.4", "xmax = 33", "over frames 0 to 825"),
    ],
)
def test_a_file_that_is_spoilt_is_refused(file, old, new, told):
    with pytest.raises(BadFile, match=told):
        read(file(LONG.replace(old, new, 1)), FPS, 75)


def test_the_binary_form_is_refused_with_what_to_do(file):
    with pytest.raises(BadFile, match="a binary TextGrid.*Save as text file"):
        read(file(b"ooBinaryFile\x08TextGrid\x00\x00"), FPS)


def test_a_clip_without_frames_is_no_textgrid(tmp_path):
    with pytest.raises(BadFile, match="without frames"):
        write(Timeline("a", FPS, 0, {}), tmp_path / "a.TextGrid")
