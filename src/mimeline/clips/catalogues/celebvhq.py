"""CelebV-HQ's catalogue: clips as JSON, attributes as ones and zeros under shared names."""

from pathlib import Path
from typing import Any

from mimeline.clips.catalogues.json_records import (
    GARBLED,
    clip_name,
    few,
    name,
    number,
    pairs_of,
    part,
    read_object,
    unfit,
    whole_clip,
)
from mimeline.clips.intervals import Interval, outside_clip, over, placed
from mimeline.errors import BadFile, MimelineError

EXPECTED = "a CelebV-HQ catalogue: meta_info with names, and clips"
RECORD = "ytb_id, duration, bbox and attributes, with a 0 or 1 per name of meta_info"
UNCERTAIN_S = 0.01  # emotions' times have two decimals
MALE, FEMALE = "male", "female"


def read(data: Path, info: str) -> tuple[list[dict], list[tuple[str, MimelineError]]]:
    """Clips of a catalogue, and the records that are none, each with its id and what is wrong.

    data: the folder that info, a file name, lies in.
    Returns rows with clip_id, source_id, subject_id, start_s, end_s, bbox_*, width, height (absent
    where the box is in shares of the picture), actions, emotions and attributes. An action holds
    for the whole clip, since nobody says when: its uncertainty is None. So does an emotion that
    has no times. `female` is what is not `male`, where an appearance is told at all.
    Raises BadFile if the file is no such catalogue.
    """
    path = data / info
    content = read_object(path, EXPECTED)
    looks, acts = _names(content, path)
    rows, bad = [], []
    for key, record in pairs_of(content["clips"]):
        clip_id = clip_name(key)
        try:
            row = {"clip_id": clip_id} | whole_clip(record)
            told = part(part(record)["attributes"])
            length = row["end_s"] - row["start_s"]
            actions = [over(action, length) for action in _set(told["action"], acts)]
            row |= {"actions": actions, "attributes": _appearance(told["appearance"], looks)}
            emotions, outside = _emotions(told["emotion"], length)
            rows.append(row | {"emotions": emotions, "notes": outside_clip(outside)})
        except GARBLED as error:
            bad.append((clip_id, unfit(path, key, error, RECORD)))
    return rows, bad


def _names(content: dict[str, Any], path: Path) -> tuple[list[str], list[str]]:
    """The names that the ones and zeros of appearance and action stand for."""
    try:
        if not isinstance(part(content)["clips"], dict):
            raise TypeError("clips that are no object")
        meta = part(content["meta_info"])
        mappings = (meta["appearance_mapping"], meta["action_mapping"])
        looks, acts = ([name(word) for word in mapping] for mapping in mappings)
        return looks, acts
    except GARBLED as error:
        found = f"no {error}" if isinstance(error, KeyError) else str(error)
        raise BadFile(
            path,
            place="meta_info and clips",
            found=found,
            expected=EXPECTED,
            remedy="Give celebvhq_info.json as published; for CelebV-Text set catalogue.format.",
        ) from error


def _set(flags: Any, names: list[str]) -> list[str]:
    """The names whose flag is 1."""
    if len(few(flags)) != len(names):
        raise ValueError(f"{len(flags)} flags for the {len(names)} names of meta_info")
    if any(isinstance(flag, bool) or flag not in (0, 1) for flag in flags):
        raise ValueError("other flags than 0 and 1")
    return [word for word, flag in zip(names, flags, strict=True) if flag]


def _appearance(flags: Any, names: list[str]) -> list[str]:
    """What is set; and `female` where `male` is not, but something else is."""
    found = _set(flags, names)
    if MALE in names and MALE not in found and found:
        return [FEMALE, *found]
    return found


def _emotions(emotion: Any, length: float) -> tuple[list[Interval], list[str]]:
    """One emotion of the whole clip, or several with their seconds in it; gaps stay gaps.

    And those that lie outside of the clip.
    """
    labels = part(emotion)["labels"]
    if isinstance(labels, str):
        return [over(name(labels), length)] if labels else [], []
    told = [
        (name(part(label)["emotion"]), number(label["start_sec"]), number(label["end_sec"]))
        for label in few(labels)
    ]
    return placed(told, length, UNCERTAIN_S)
