"""What the preview tells of a motion: its frames, its timeline, where each channel comes from."""

from typing import Any

import numpy as np

from mimeline.motion.formats.film import TRACK_NAMES
from mimeline.motion.motion import Motion
from mimeline.reporting import words
from mimeline.reporting.style import colours, readable_on
from mimeline.studio.labelling import DARK
from mimeline.studio.previewed import Clip
from mimeline.timeline.timeline import Interval, Timeline
from mimeline.vocabulary import CHANNELS, TRACKS

NO_TIMELINE = "No timeline travels with this motion."
RULE = "A timeline without a motion: the face acts it by rule, each action to one height."
# The start of channels' names → what they are listed under.
GROUPS = {
    "brow": "Brows",
    "eye": "Eyes",
    "gaze": "Gaze",
    "cheek": "Cheeks and nose",
    "nose": "Cheeks and nose",
    "jaw": "Jaw and tongue",
    "tongue": "Jaw and tongue",
    "mouth": "Mouth",
    "head": "Head",
}
DIGITS = {"1": 3, "rad": 1}  # of a coefficient, and of an angle in degrees


def told(clip: Clip) -> dict[str, Any]:
    """A clip as the page shows it. Times of the timeline are seconds: its rate may be another."""
    motion = clip.motion
    valid = motion.frames["valid"].to_numpy(bool)
    return {
        "name": clip.name,
        "acted": clip.acted,
        "fps": float(motion.fps),
        "n_frames": len(motion),
        "seconds": motion.seconds,
        "facts": _facts(clip, valid),
        "notes": [note for note in (RULE if clip.acted else "", clip.note) if note],
        "invalid": _runs(~valid),
        "asked": bool(motion.made),
        "timeline": None if motion.timeline is None else _timeline(motion.timeline),
        "no_timeline": NO_TIMELINE,
        "states": _states(clip),
        "channels": _channels(motion),
    }


def _facts(clip: Clip, valid: np.ndarray) -> list[str]:
    motion = clip.motion
    rate = f"{float(motion.fps):.2f}".rstrip("0").rstrip(".")
    facts = [f"{words.plural(len(motion), 'frame')} at {rate} fps, {motion.seconds:.2f} s"]
    if not valid.all():
        facts.append(f"not tracked: {words.plural(int((~valid).sum()), 'frame')}")
    if not clip.acted:
        facts += [f"{name}: {value}" for name, value in motion.made.items()]
    return facts


def _timeline(timeline: Timeline) -> dict[str, Any]:
    fps = float(timeline.fps)
    return {
        "tracks": [
            {
                "name": TRACK_NAMES.get(track, track),
                "words": words.TRACK_NAMES[track],
                "intervals": [_interval(interval, fps) for interval in intervals],
            }
            for track, intervals in timeline.tracks.items()
        ],
        "absent": [TRACK_NAMES.get(t, t) for t in TRACKS if t not in timeline.tracks],
        "seconds": timeline.seconds,
    }


def _interval(interval: Interval, fps: float) -> dict[str, Any]:
    colour = colours()[interval.action][DARK]
    side = f", {interval.side}" if interval.side else ""
    return {
        "words": words.spaced(interval.action) + side,
        "short": words.short(interval.action) + side,
        "start": interval.start / fps,
        "end": interval.end / fps,
        "side": interval.side,
        "colour": colour,
        "on": readable_on(colour),
    }


def _states(clip: Clip) -> dict[str, str]:
    """What it is called that a channel is known, and that it is not."""
    known = "told" if clip.acted else "made" if clip.motion.made else "measured"
    return {"known": known, "absent": f"not {known}"}


def _channels(motion: Motion) -> list[dict[str, Any]]:
    """Every channel: where it comes from and, where it is known, its values; angles in degrees."""
    moved = set(motion.moved)
    found = []
    for name, channel in CHANNELS.items():
        origin = motion.origins.get(name)
        entry = {
            "name": name,
            "group": next(group for start, group in GROUPS.items() if name.startswith(start)),
            "unit": "°" if channel.unit == "rad" else "",
            "known": name in moved,
            "origin": "" if origin is None else origin.text,
            "quality": None if origin is None or name not in moved else origin.quality,
        }
        if name in moved:
            values = motion.frames[name].to_numpy(np.float64, na_value=np.nan)
            values = np.degrees(values) if channel.unit == "rad" else values
            rounded = np.round(values, DIGITS[channel.unit]).tolist()
            entry["values"] = [None if value != value else value for value in rounded]
        found.append(entry)
    return found


def _runs(holds: np.ndarray) -> list[list[int]]:
    """Half-open runs of frames for which it holds."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], holds, [False]]).astype(np.int8)))
    return edges.reshape(-1, 2).tolist()
