"""The user's editor: a script stands for the person."""

import io
import sys
from fractions import Fraction
from pathlib import Path

import pytest

from mimeline.directions import editing
from mimeline.directions.editing import NoEditor, edited
from mimeline.errors import BadFile
from mimeline.timeline.timeline import Interval, Timeline

TIMELINE = Timeline(
    "me",
    Fraction(25),
    100,
    {
        "mouth": [Interval("Smile", 25, 50)],
        "brow": [Interval("BrowUp", 0, 25, side="left")],
        "lid": [],
    },
)


@pytest.fixture
def editor(tmp_path, monkeypatch):
    """Makes a program the editor: one that runs Python code on the file's text, `text`."""
    monkeypatch.setattr(editing.tempfile, "tempdir", str(tmp_path))
    monkeypatch.delenv("VISUAL", raising=False)

    def make(code: str) -> None:
        script = tmp_path / "editor.py"
        script.write_text(
            "import sys, pathlib\n"
            "path = pathlib.Path(sys.argv[1])\n"
            "text = path.read_text(encoding='utf-8')\n"
            f"{code}\n"
            "path.write_text(text, encoding='utf-8')\n"
        )
        monkeypatch.setenv("EDITOR", f"'{sys.executable}' '{script}'")

    return make


def left_behind(tmp_path: Path) -> list[Path]:
    return [*tmp_path.glob("mimeline-*/*")]


def test_a_timeline_that_nobody_changes_comes_back_as_it_was(editor, tmp_path):
    editor("")
    said = []
    assert edited(TIMELINE, said.append) == TIMELINE
    assert "NAME # start in s" in said[0] and "4 s" in said[0]
    assert not left_behind(tmp_path)


def test_lines_are_taken_out_changed_and_added(editor):
    editor(
        "lines = [line for line in text.splitlines() if 'BrowUp' not in line]\n"
        "text = '\\n\\n'.join([*lines, 'GazeLeft # 1.0 # 2.0 # gaze_h', ''])"
    )
    found = edited(TIMELINE, lambda _: None)
    assert [(own.action, own.start, own.end) for own in found] == [
        ("Smile", 25, 50),
        ("GazeLeft", 25, 50),
    ]
    assert (found.n_frames, found.clip_id) == (100, "me")
    assert found.tracks["brow"] == () and found.tracks["lid"] == ()


def test_everything_may_be_taken_out(editor):
    editor("text = ''")
    assert [*edited(TIMELINE, lambda _: None)] == []


@pytest.mark.parametrize(
    "text", ["Juggle # 0 # 1 # mouth", "Smile # 0 # 9 # mouth", "Smile # x # 1 # mouth", "Smile"]
)
def test_what_cannot_be_used_is_told_and_kept(editor, tmp_path, monkeypatch, text):
    editor(f"text = {text!r}")
    monkeypatch.setattr(sys, "stdin", io.StringIO())
    with pytest.raises(BadFile, match=r"timeline\.txt"):
        edited(TIMELINE, lambda _: None)
    assert [path.read_text().strip() for path in left_behind(tmp_path)] == [text]


@pytest.mark.parametrize(
    "code", ["path.unlink(); sys.exit()", "path.write_bytes(b'\\xff'); sys.exit()"]
)
def test_a_file_that_is_gone_or_no_text_is_told(editor, monkeypatch, code):
    editor(code)
    monkeypatch.setattr(sys, "stdin", io.StringIO())
    with pytest.raises(BadFile, match=r"timeline\.txt.*"):
        edited(TIMELINE, lambda _: None)


def test_at_a_terminal_it_is_opened_again(editor, tmp_path, monkeypatch):
    editor("text = 'Smile # 0 # 1 # mouth' if 'Juggle' in text else 'Juggle # 0 # 1 # mouth'")
    monkeypatch.setattr("sys.stdin.isatty", lambda: True, raising=False)
    monkeypatch.setattr("builtins.input", lambda _: "")
    said = []
    found = edited(TIMELINE, said.append)
    assert [(own.action, own.end) for own in found] == [("Smile", 25)]
    assert "Juggle" in said[1] and not left_behind(tmp_path)


def test_giving_up_keeps_what_was_written(editor, tmp_path, monkeypatch):
    editor("text = 'Juggle # 0 # 1 # mouth'")
    monkeypatch.setattr("sys.stdin.isatty", lambda: True, raising=False)

    def interrupt(_: str) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("builtins.input", interrupt)
    said = []
    with pytest.raises(KeyboardInterrupt):
        edited(TIMELINE, said.append)
    assert str(left_behind(tmp_path)[0]) in said[-1]


def test_an_editor_that_is_none_or_fails_is_told(editor, tmp_path, monkeypatch):
    editor("sys.exit(3)")
    with pytest.raises(NoEditor, match="ended with 3.*export EDITOR"):
        edited(TIMELINE, lambda _: None)
    monkeypatch.setenv("EDITOR", "vim '")
    with pytest.raises(NoEditor, match="EDITOR=vim '"):
        edited(TIMELINE, lambda _: None)
    monkeypatch.setenv("EDITOR", "/nowhere/ed")
    with pytest.raises(NoEditor, match="nowhere"):
        edited(TIMELINE, lambda _: None)
    monkeypatch.delenv("EDITOR")
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(NoEditor, match="found none"):
        edited(TIMELINE, lambda _: None)
    assert not left_behind(tmp_path)
