"""What two files of timelines differ in, for people and for programs."""

import json
from collections.abc import Sequence
from dataclasses import asdict
from fractions import Fraction
from pathlib import Path

from mimeline.errors import printable
from mimeline.inspection.layout import BOLD, FAINT, GREEN, RED, YELLOW, Paint, painter
from mimeline.reporting import words
from mimeline.timeline.comparison import Agreement, Change, Difference, Kind
from mimeline.timeline.timeline import Interval

MARKS: dict[Kind, tuple[str, str]] = {
    "only in a": ("-", RED),
    "only in b": ("+", GREEN),
    "moved": ("~", YELLOW),
    "another": ("!", YELLOW),
}


def as_text(found: Difference, a: Path, b: Path, colour: bool = False) -> str:
    """What a person reads: track by track, frames and seconds. a, b: the files."""
    paint = painter(colour)
    fps, n_frames = found.a.fps, found.a.n_frames
    names = " and ".join(dict.fromkeys((found.a.clip_id, found.b.clip_id)))
    length = f"{n_frames} frames at {fps} fps, {float(n_frames / fps):.2f} s"
    lines = [f"{paint(printable(names), BOLD)}: {_count(found)} ({length})"]
    if found:
        lines += [
            f"  {paint(mark, code)} {printable(str(file))}"
            for mark, code, file in ((*MARKS["only in a"], a), (*MARKS["only in b"], b))
        ]
    rows = _rows(found.changes, fps, paint)
    for track, agreement in found.agreement.items():
        if own := [row for row, change in rows if change.track == track]:
            lines += ["", f"{paint(track, BOLD)}  {paint(_agreed(agreement), FAINT)}", *own]
    changed = {change.track for change in found.changes}
    told = {
        "the same": [track for track in found.agreement if track not in changed],
        f"measured only in {a}": found.only_a,
        f"measured only in {b}": found.only_b,
    }
    lines += [""] if found else []
    lines += [
        f"{paint(printable(name), FAINT)}: {', '.join(own)}" for name, own in told.items() if own
    ]
    return "\n".join(lines) + "\n"


def as_json(found: Difference, a: Path, b: Path) -> str:
    """What a program reads."""
    told = {
        "a": str(a),
        "b": str(b),
        "same": not found,
        "fps": str(found.a.fps),
        "n_frames": found.a.n_frames,
        "changes": [
            {
                "track": change.track,
                "kind": change.kind,
                "a": change.a and asdict(change.a),
                "b": change.b and asdict(change.b),
                "start_shift": change.shift[0],
                "end_shift": change.shift[1],
            }
            for change in found.changes
        ],
        "agreement": {track: asdict(agreed) for track, agreed in found.agreement.items()},
        "only_a": found.only_a,
        "only_b": found.only_b,
    }
    return json.dumps(told, indent=1, ensure_ascii=False) + "\n"


def _count(found: Difference) -> str:
    tracks = words.plural(len(found.only_a) + len(found.only_b), "track")
    told = [words.plural(len(found.changes), "difference")] if found.changes else []
    told += [f"{tracks} in one of them only"] if found.only_a or found.only_b else []
    return ", ".join(told) or "no difference"


def _agreed(agreement: Agreement) -> str:
    kappa = "" if agreement.kappa is None else f", kappa {agreement.kappa:.2f}"
    return f"{words.percent(agreement.share)} of frames agree{kappa}"


def _rows(changes: Sequence[Change], fps: Fraction, paint: Paint) -> list[tuple[str, Change]]:
    """A line for each change, in columns."""
    cells = []
    for change in changes:
        at = change.a or change.b
        shown = " → ".join(dict.fromkeys(_shown(i) for i in (change.a, change.b) if i))
        seconds = f"{float(at.start / fps):.2f} to {float(at.end / fps):.2f} s"
        cells.append((shown, f"{at.start} to {at.end}", seconds))
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    lines = []
    for change, (shown, frames, seconds) in zip(changes, cells, strict=True):
        mark, code = MARKS[change.kind]
        name = paint(f"{mark} {shown.ljust(widths[0])}", code)
        time = paint(seconds.rjust(widths[2]), FAINT)
        line = f"  {name}  {frames.rjust(widths[1])}  {time}  {_moved(change)}"
        lines.append((line.rstrip(), change))
    return lines


def _shown(interval: Interval) -> str:
    return f"{interval.action} {interval.side}" if interval.side else interval.action


def _moved(change: Change) -> str:
    told = []
    for verb, frames in zip(("starts", "ends"), change.shift, strict=True):
        if frames:
            way = "later" if frames > 0 else "earlier"
            told.append(f"{verb} {words.plural(abs(frames), 'frame')} {way}")
    return ", ".join(told)
