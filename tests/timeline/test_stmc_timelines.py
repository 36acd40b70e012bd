from fractions import Fraction

import pytest

from mimeline.errors import BadFile
from mimeline.timeline.files import lint, read, read_all, write
from mimeline.timeline.timeline import Interval, Timeline

FPS = Fraction(25)


@pytest.fixture
def file(tmp_path):
    def made(text):
        path = tmp_path / "clip.txt"
        path.write_text(text, encoding="utf-8")
        return path

    return made


def test_a_line_is_action_start_end_and_track(tmp_path):
    tracks = {
        "brow": [Interval("BrowUp", 12, 50, "left"), Interval("BrowDown", 60, 62)],
        "mouth": [Interval("Smile", 0, 25)],
    }
    write(Timeline("a", FPS, 75, tracks), tmp_path / "a.txt")
    assert (tmp_path / "a.txt").read_text() == (
        "Smile # 0.0 # 1.0 # mouth\nBrowUp # 0.48 # 2.0 # brow left\nBrowDown # 2.4 # 2.48 # brow\n"
    )


def test_several_parts_each_have_the_interval_and_the_action_tells_a_part_that_lacks(file):
    path = file("BrowUp # 0.4 # 2 # brow left # brow right\nSmile # .4 # 2.\n")
    assert read(path, FPS, 75).tracks == {
        "brow": (Interval("BrowUp", 10, 50, "left"), Interval("BrowUp", 10, 50, "right")),
        "mouth": (Interval("Smile", 10, 50),),
    }


def test_empty_lines_set_timelines_apart(file):
    path = file("\nBrowUp # 0.4 # 2 # brow\n\n\nSmile # 0.4 # 2 # mouth\n\n")
    assert [list(t.tracks) for t in read_all(path, FPS, 75)] == [["brow"], ["mouth"]]
    assert list(read(path, FPS, 75, "clip_2").tracks) == ["mouth"]
    with pytest.raises(BadFile, match='found 2 clips, "clip_1, clip_2".*--clip clip_1'):
        read(path, FPS, 75)


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("walking in a circle # 0.0 # 6.0 # legs", 'track "legs"'),
        ("raises the brows # 0.0 # 2.0 # brow", 'action "raises the brows"'),
        ("BrowUp # 0.0 # 2.0 # brw", "Did you mean brow"),
        ("BrowUp 0.0 2.0 brow", "line 1: .*expected ACTION # START # END # TRACK"),
        ("BrowUp # 0:01 # 2.0 # brow", "times in seconds"),
        ("BrowUp # 0 # 1e999999999 # brow", "times in seconds"),
        ("BrowUp # 0 # nan # brow", "times in seconds"),
        ("BrowUp # 0 # " + "9" * 5000 + " # brow", "times in seconds"),
        ("BrowUp # 0 # 9e99 # brow", "within the clip"),
        ("BrowUp # -1 # 2 # brow", "within the clip"),
        ("BrowUp # 0 # 2 # brow #", 'track ""'),
    ],
)
def test_a_line_that_is_wrong_is_refused(file, line, told):
    with pytest.raises(BadFile, match=told):
        read(file(line + "\n"), FPS, 75)


def test_every_wrong_line_is_told(file):
    problems = lint(file("one\ntwo # 3\nBrowUp # 0 # 2 # brow\n"), FPS, 75)
    assert [problem.place for problem in problems] == ["line 1", "line 2"]
