"""What our JSON looks like: its version and its schema, made of the vocabulary."""

import json

from mimeline.timeline.timeline import SIDES, SOURCES
from mimeline.vocabulary import TRACKS, track_actions

VERSION = 1


def json_schema() -> dict:
    """The JSON Schema of a file: a clip, or a list of clips."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Facial-action timelines",
        "description": "A clip's actions per track, over half-open intervals of frames.",
        "anyOf": [{"$ref": "#/$defs/clip"}, {"type": "array", "items": {"$ref": "#/$defs/clip"}}],
        "$defs": {"clip": _clip(), **{track: _track(track) for track in TRACKS}},
    }


def _clip() -> dict:
    tracks = {track: {"$ref": f"#/$defs/{track}"} for track in TRACKS}
    return {
        "type": "object",
        "properties": {
            "schema_version": {"const": VERSION},
            "clip_id": {"type": "string", "minLength": 1},
            "fps": {
                "description": "Frames per second, num / den: 30000 / 1001.",
                "type": "object",
                "properties": {name: {"type": "integer", "minimum": 1} for name in ("num", "den")},
                "required": ["num", "den"],
                "additionalProperties": False,
            },
            "n_frames": {"type": "integer", "minimum": 0},
            "tracks": {
                "description": "A key per measured track; an empty one is neutral throughout.",
                "type": "object",
                "properties": tracks,
                "additionalProperties": False,
            },
        },
        "required": ["schema_version", "clip_id", "fps", "n_frames", "tracks"],
        "additionalProperties": False,
    }


def _track(track: str) -> dict:
    interval = {
        "type": "object",
        "properties": {
            "action": {"enum": list(track_actions(track))},
            "start_frame": {"type": "integer", "minimum": 0},
            "end_frame": {
                "description": "The first frame that is no longer in it.",
                "type": "integer",
                "minimum": 1,
            },
            "side": {"description": "The subject's; both where it lacks.", "enum": list(SIDES)},
            "source": {"enum": list(SOURCES)},
            "cluster": {"type": "integer", "minimum": 0},
            "confidence": {"type": "number", "minimum": 0, "maximum": 1},
        },
        "required": ["action", "start_frame", "end_frame"],
        "additionalProperties": False,
    }
    return {"type": "array", "items": interval}


def schema_text() -> str:
    """The schema as `resources/timeline.schema.json` has it."""
    return json.dumps(json_schema(), indent=2) + "\n"
