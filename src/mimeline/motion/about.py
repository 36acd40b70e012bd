"""What travels with a motion: where each channel comes from, what was asked for, how it was made.

It is JSON: inside the file where its format has a place, else in a file beside it. A file may come
from anybody, so that what is read here is believed of nothing but what it can tell.
"""

import json
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from mimeline import __version__
from mimeline.atomic import whole
from mimeline.errors import BadFile
from mimeline.motion.motion import Motion
from mimeline.timeline.checks import judge
from mimeline.timeline.clock import frame_rate
from mimeline.timeline.formats import json_file
from mimeline.tracking.take import Origin
from mimeline.vocabulary import CHANNELS

UNITS = {"coefficients": "0 to 1", "head and gaze": "radians, subject's left and up are positive"}
BESIDE = ".mimeline.json"  # in place of a file's ending
MOST_BYTES = 50_000_000


def about(motion: Motion) -> dict[str, Any]:
    """What is to be known of a motion, as plain values."""
    moved = set(motion.moved)
    told = {name: motion.origins.get(name) for name in CHANNELS}
    channels = {
        name: {"measured": name in moved}
        | ({} if origin is None else {"origin": origin.text})
        | ({} if origin is None or origin.quality is None else {"quality": origin.quality})
        for name, origin in told.items()
    }
    timeline = motion.timeline
    return {
        "mimeline": __version__,
        "fps": str(motion.fps),
        "frames": len(motion),
        "units": UNITS,
        "made": dict(motion.made),
        "channels": channels,
        "timeline": None if timeline is None else json.loads(json_file.write([timeline])),
    }


def informed(motion: Motion, told: Mapping[str, Any]) -> Motion:
    """A motion as it was read, with what is told of it: `about`, perhaps written by somebody else.

    A channel that was not measured is NaN again, whatever stands for it in the file. What does not
    hold together is left out; the rate is for the reader to judge.
    """
    channels = told.get("channels")
    channels = channels if isinstance(channels, dict) else {}
    entries = {n: entry for n, entry in channels.items() if n in CHANNELS and type(entry) is dict}
    frames = motion.frames.copy()
    rest = [name for name, entry in entries.items() if entry.get("measured") is False]
    frames[rest] = np.float32(np.nan)
    origins = {**motion.origins, **{name: _origin(entry) for name, entry in entries.items()}}
    made = told.get("made")
    return replace(
        motion,
        frames=frames,
        origins=origins,
        timeline=_timeline(told.get("timeline")),
        made=made if isinstance(made, dict) else {},
    )


def rate(told: Mapping[str, Any]) -> Fraction | None:
    """Frames per second as they are told, or None."""
    try:
        return frame_rate(told.get("fps", ""))
    except (AttributeError, ValueError):
        return None


def beside(path: Path) -> Path:
    """Where it lies that has no place in the file at path."""
    return path.with_name(f"{path.stem}{BESIDE}")


def write_beside(path: Path, motion: Motion, **more: Any) -> None:
    """Write it beside the file at path. more: what else is to be known of that file."""
    text = json.dumps(about(motion) | more, indent=2, ensure_ascii=False, allow_nan=False)
    with whole(beside(path)) as temporary:
        temporary.write_text(f"{text}\n", encoding="utf-8")


def read_beside(path: Path) -> dict[str, Any]:
    """What lies beside the file at path; empty where nothing does. Raises BadFile for no JSON."""
    file = beside(path)
    if not file.is_file():
        return {}
    if file.stat().st_size > MOST_BYTES:
        raise _bad(file, f"{file.stat().st_size // 10**6} MB")
    return parsed(file.read_bytes(), file)


def parsed(content: bytes | str, file: Path) -> dict[str, Any]:
    """What a text in a file tells. Raises BadFile for what is no JSON object."""
    try:
        value = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise _bad(file, str(error)) from error
    if not isinstance(value, dict):
        raise _bad(file, f"a JSON {type(value).__name__}")
    return value


def _bad(file: Path, found: str) -> BadFile:
    return BadFile(
        file,
        found=found,
        expected="what mimeline tells of a motion, a JSON object",
        remedy="Write the motion again, or delete it: the motion alone can be read.",
    )


def _origin(entry: Mapping[str, Any]) -> Origin:
    text, quality = entry.get("origin"), entry.get("quality")
    known = type(quality) in (int, float) and 0 <= quality <= 1
    return Origin(
        text if isinstance(text, str) else "",
        entry.get("measured") is True,
        float(quality) if known else None,
    )


def _timeline(told: object):
    if told is None:
        return None
    return judge(json_file.draft(told), "timeline").timeline
