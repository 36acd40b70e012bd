"""WebVTT: a cue per interval, in which the track speaks: `<v brow left>BrowUp</v>`.

Our own files begin with a note of what WebVTT has no place for: clip, fps, frames, tracks.
Source: W3C, WebVTT: The Web Video Text Tracks Format, sections 4 and 6.
"""

import html
import json
import re
from collections.abc import Iterator, Sequence
from fractions import Fraction
from pathlib import Path

from mimeline.errors import BadFile
from mimeline.timeline.clock import frame_rate, milliseconds
from mimeline.timeline.draft import (
    Draft,
    DraftInterval,
    Problem,
    ignored,
    is_foreign,
    shown,
    split_tier,
    tier_name,
)
from mimeline.timeline.formats.text_file import read_text
from mimeline.timeline.timeline import Timeline

NOTE = "NOTE mimeline "
NOTE_FORM = '{"clip": "a", "fps": "30000/1001", "frames": 300, "tracks": ["brow"]}'

_TIME = r"(?:([0-9]{2,9}):)?([0-5][0-9]):([0-5][0-9])\.([0-9]{3})"
_ARROW = "-->"
_TIMES = re.compile(rf"[ \t]*{_TIME}[ \t]*{_ARROW}[ \t]*{_TIME}(?:[ \t].*)?", re.ASCII)
_VOICE = re.compile(r"<v(?:\.[^\s<>]*)?[ \t]([^<>]*)>([^<]*)(?:</v>)?")
_TAG = re.compile(r"<[^<>]*>")
_NO_CUE = ("NOTE", "STYLE", "REGION")


def read(path: Path) -> list[Draft]:
    """The one draft that the file holds."""
    text = read_text(path, "a WebVTT file").replace("\r\n", "\n").replace("\r", "\n")
    lines = text.split("\n")
    if not re.fullmatch(r"WEBVTT(?:[ \t].*)?", lines[0]):
        raise BadFile(
            path,
            place="line 1",
            found=shown(lines[0]),
            expected="WEBVTT, with which every such file begins",
            remedy="See that it is a WebVTT file; SubRip (.srt) is not read.",
        )
    facts: dict = {}
    spoken: list[tuple[str, DraftInterval]] = []  # with its voice as written
    problems: list[Problem] = []
    for number, block in _blocks(lines):
        times_below = any(_ARROW in line for line in block[1:])
        if number == 1 and not times_below:
            continue  # what stands below WEBVTT is its header
        if number == 1:
            number, block = 2, block[1:]
        if block[0].startswith(NOTE):
            facts = _facts(path, number, block[0].removeprefix(NOTE))
        if block[0].split(maxsplit=1)[0] in _NO_CUE and not times_below:
            continue  # right above times, a note is a cue's name
        timing = 0 if _ARROW in block[0] else 1
        if match := _TIMES.fullmatch(block[timing]) if len(block) > timing else None:
            spoken += _spoken(f"line {number + timing}", match, block[timing + 1 :])
        else:
            problems.append(_no_cue(number, block))
    said: dict[str, list[str]] = {}
    for voice, entry in spoken:
        said.setdefault(voice, []).append(entry.action)
    foreign = {v: len(found) for v, found in said.items() if v and is_foreign(v, tuple(found))}
    problems += [ignored(f"voice {shown(voice)}", count) for voice, count in foreign.items()]
    intervals = tuple(entry for voice, entry in spoken if voice not in foreign)
    told = {"clip_id": None} | facts
    return [Draft(intervals=intervals, in_seconds=True, problems=tuple(problems), **told)]


def _blocks(lines: list[str]) -> Iterator[tuple[int, list[str]]]:
    """Lines between empty ones, with the number of the first.

    Times begin a block as well, but for those below its first line, which is then a cue's name.
    """
    block: list[str] = []
    for number, line in enumerate([*lines, ""], start=1):
        is_named = len(block) == 1 and _ARROW not in block[0]
        if block and (not line.strip() or (_ARROW in line and not is_named)):
            yield number - len(block), block
            block = []
        if line.strip():
            block.append(line)


def _facts(path: Path, number: int, note: str) -> dict:
    try:
        told = json.loads(note)
        if not isinstance(told, dict) or not isinstance(told.get("clip"), str | None):
            raise ValueError
        frames, tracks = told.get("frames"), told.get("tracks", [])
        if not (frames is None or (type(frames) is int and frames >= 0)):
            raise ValueError
        if not (isinstance(tracks, list) and all(isinstance(track, str) for track in tracks)):
            raise ValueError
        fps = told.get("fps")
        if not (fps is None or isinstance(fps, str) or type(fps) is int):
            raise ValueError
        return {
            "clip_id": told.get("clip") or None,
            "fps": None if fps is None else frame_rate(str(fps)),
            "n_frames": frames,
            "tracks": tuple(tracks),
        }
    except (ValueError, RecursionError) as error:
        raise BadFile(
            path,
            place=f"line {number}",
            found=shown(note),
            expected=f"a note like {NOTE_FORM}",
            remedy="Mend the note, or take the line out and say --fps and --frames.",
        ) from error


def _spoken(place: str, times: re.Match, payload: list[str]) -> Iterator[tuple[str, DraftInterval]]:
    start, end = _seconds(times.groups()[:4]), _seconds(times.groups()[4:])
    text = "\n".join(payload)
    for voice, said in _VOICE.findall(text):
        voice = html.unescape(voice).strip()
        track, side = split_tier(voice)
        action = html.unescape(said).strip()
        yield voice, DraftInterval(place, track, action, start, end, side=side)
    for line in _VOICE.sub("", text).splitlines():
        if action := html.unescape(_TAG.sub("", line)).strip():
            yield "", DraftInterval(place, None, action, start, end)


def _seconds(parts: Sequence[str | None]) -> Fraction:
    hours, minutes, seconds, thousandths = (int(part or 0) for part in parts)
    return Fraction(((hours * 60 + minutes) * 60 + seconds) * 1000 + thousandths, 1000)


def _no_cue(number: int, block: list[str]) -> Problem:
    return Problem(
        f"line {number}",
        found=shown(block[0]),
        expected="a cue: 00:00:01.000 --> 00:00:02.000, and below it <v brow>BrowUp</v>",
        remedy="Write it so, or take it out.",
    )


def write(timelines: Sequence[Timeline]) -> str:
    """The timeline as text. Raises ValueError where milliseconds cannot tell frames apart."""
    (timeline,) = timelines
    told = {
        "clip": timeline.clip_id,
        "fps": str(timeline.fps),
        "frames": timeline.n_frames,
        "tracks": list(timeline.tracks),
    }
    note = json.dumps(told).replace(">", "\\u003e")  # a note must not hold an arrow
    parts = ["WEBVTT\n", f"{NOTE}{note}\n"]
    for interval in sorted(timeline, key=lambda interval: interval.start):
        start, end = (_stamp(frame, timeline.fps) for frame in (interval.start, interval.end))
        tier = tier_name(interval.track, interval.side)
        parts.append(f"{start} --> {end}\n<v {tier}>{interval.action}</v>\n")
    return "\n".join(parts)


def _stamp(frame: int, fps: Fraction) -> str:
    rest, thousandths = divmod(milliseconds(frame, fps), 1000)
    minutes, seconds = divmod(rest, 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours:02d}:{minutes:02d}:{seconds:02d}.{thousandths:03d}"
