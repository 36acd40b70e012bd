"""A timeline in the user's own editor, a line for each action."""

import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from mimeline.errors import BadFile, MimelineError, unreadable
from mimeline.timeline import files
from mimeline.timeline.checks import judge
from mimeline.timeline.timeline import Timeline

EDITORS = ("nano", "vim", "vi", "notepad")
FORM, ENDING = "stmc", ".txt"  # the least to type
HOW = "An action a line: NAME # start in s # end in s # track, and left or right for one side."


class NoEditor(MimelineError):
    """There is no editor, or it ended badly."""


def edited(timeline: Timeline, say: Callable[[str], None]) -> Timeline:
    """The timeline as it stands when the user closes the editor, as long as it was.

    A text that is no timeline is said to be none, and opened again where somebody sits at a
    terminal; else, and on Ctrl-C, it is kept. Tracks that were measured still are. Raises NoEditor;
    BadFile for what cannot be used.
    """
    folder = Path(tempfile.mkdtemp(prefix="mimeline-"))
    path = folder / f"timeline{ENDING}"
    files.write(timeline, path, FORM)
    say(f"{HOW} The clip has {timeline.seconds:g} s.")
    while True:
        try:
            _open(path)
            found = _read(path, timeline)
        except NoEditor:
            shutil.rmtree(folder)
            raise
        except BadFile as error:
            if not sys.stdin.isatty():
                raise
            say(f"mimeline: {error}")
            try:
                input("Press Enter to go on editing, Ctrl-C to give up. ")
            except (KeyboardInterrupt, EOFError):
                say(f"\nWhat you wrote is in {path}")
                raise KeyboardInterrupt from None
        else:
            shutil.rmtree(folder)
            return found


def _open(path: Path) -> None:
    editor = _editor()
    try:
        code = subprocess.run([*editor, str(path)], check=False).returncode
    except OSError as error:
        raise _no_editor(str(error)) from error
    if code:
        raise _no_editor(f"{editor[0]}, which ended with {code}")


def _editor() -> list[str]:
    for name in ("VISUAL", "EDITOR"):
        if told := os.environ.get(name, "").strip():
            try:
                return shlex.split(told)
            except ValueError as error:
                raise _no_editor(f"{name}={told} ({error})") from error
    for name in EDITORS:
        if path := shutil.which(name):
            return [path]
    raise _no_editor("none")


def _no_editor(found: str) -> NoEditor:
    return NoEditor(
        "the editor",
        found=found,
        expected="one that opens and waits until the file is closed",
        remedy="Name it: export EDITOR=nano, or EDITOR='code --wait'.",
    )


def _read(path: Path, timeline: Timeline) -> Timeline:
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise unreadable(path, error, expected="an action a line, in UTF-8", remedy=HOW) from error
    lines = [line for line in text.splitlines() if line.strip()]
    path.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")
    draft = files.draft_of(path, format=FORM)
    judged = judge(draft, timeline.clip_id, timeline.fps, timeline.n_frames)
    if judged.timeline is None:
        first = judged.problems[0]
        raise BadFile(
            path,
            place=first.place,
            found=first.found,
            expected=first.expected,
            remedy=first.remedy,
        )
    tracks = dict.fromkeys(timeline.tracks, ()) | judged.timeline.tracks
    return Timeline(timeline.clip_id, timeline.fps, timeline.n_frames, tracks)
