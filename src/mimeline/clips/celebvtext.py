"""CelebV-Text's catalogue: clips as JSON, actions with whole-second times of the source video."""

import json
from pathlib import Path

from mimeline.errors import BadFile


def read(data: Path, info: str, annotations: str | None) -> tuple[list[dict], dict[str, str]]:
    """Clips of a catalogue, and the records that are none, with what is wrong with each.

    data: the folder that info and annotations (file names) lie in.
    Returns rows with clip_id, source_id, subject_id, start_s, end_s, bbox_*, width, height (None
    where the box is in shares of the picture) and actions in seconds of the clip.
    Raises BadFile if a file is no catalogue.
    """
    records = _json(data / info)
    records = records.get("clips", records)
    acts = _json(data / annotations).get("act", {}) if annotations else {}
    acts = {_clip_id(key): value for key, value in acts.items()}
    rows, bad = [], {}
    for key, record in records.items():
        clip_id = _clip_id(key)
        try:
            rows.append(_row(clip_id, record, acts.get(clip_id, [])))
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            bad[clip_id] = f"{type(error).__name__}: {error}"
    return rows, bad


def _clip_id(key: str) -> str:
    return key.removesuffix(".mp4")


def _row(clip_id: str, record: dict, acts: list) -> dict:
    start, end = (float(record["duration"][key]) for key in ("start_sec", "end_sec"))
    if not 0 <= start < end:
        raise ValueError(f"duration from {start} to {end} s")
    box = {side: float(record["bbox"][side]) for side in ("top", "bottom", "left", "right")}
    in_pixels = max(box.values()) > 1  # the released file has shares, the read-me shows pixels
    return {
        "clip_id": clip_id,
        "source_id": record["ytb_id"],
        "subject_id": record.get("subject"),
        "start_s": start,
        "end_s": end,
        "width": round(box["right"] - box["left"]) if in_pixels else None,
        "height": round(box["bottom"] - box["top"]) if in_pixels else None,
        **{f"bbox_{side}": value for side, value in box.items()},
        "actions": [_action(act, start, end) for act in acts],
    }


def _action(act: list, start: float, end: float) -> dict:
    """[name, [from, to, duration, order]] with absolute h:mm:ss → seconds within the clip."""
    name, (begins, ends, *_) = act
    since, until = (min(max(_seconds(t) - start, 0.0), end - start) for t in (begins, ends))
    return {"name": name.strip().replace(" ", "_"), "start_s": since, "end_s": until}


def _seconds(time: str) -> float:
    hours, minutes, seconds = (float(part) for part in time.split(":"))
    return 3600 * hours + 60 * minutes + seconds


def _json(path: Path) -> dict:
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError as error:
        raise BadFile(
            path,
            found="no such file",
            expected="a CelebV-Text catalogue",
            remedy="Name the file in catalogue.celebvtext, or set data_dir to its folder.",
        ) from error
    try:
        content = json.loads(text, object_pairs_hook=_no_repeats)
    except ValueError as error:
        raise BadFile(
            path,
            found=str(error),
            expected="JSON with one record per clip",
            remedy="Mend the file, or take it again from where it was published.",
        ) from error
    if not isinstance(content, dict):
        raise BadFile(
            path,
            found=type(content).__name__,
            expected="an object with a record per clip",
            remedy="Point catalogue.celebvtext to the file of clips.",
        )
    return content


def _no_repeats(pairs: list[tuple]) -> dict:
    content = dict(pairs)
    if len(content) < len(pairs):
        keys = [key for key, _ in pairs]
        repeated = next(key for key in keys if keys.count(key) > 1)
        raise ValueError(f"key {repeated!r} twice")
    return content
