"""CelebV-Text's catalogue: clips as JSON, actions with whole-second times of the source video."""

import json
from pathlib import Path

from mimeline.errors import BadFile, unreadable

LARGEST_SHARE = 2.0  # of a box's edge; a face crop in pixels is larger


def read(data: Path, info: str, annotations: str | None) -> tuple[list[dict], dict[str, BadFile]]:
    """Clips of a catalogue, and the records that are none, with what is wrong with each.

    data: the folder that info and annotations (file names) lie in.
    Returns rows with clip_id, source_id, subject_id, start_s, end_s, bbox_*, width, height (None
    where the box is in shares of the picture) and actions in seconds of the clip.
    Raises BadFile if a file is no catalogue.
    """
    records = _object(_json(data / info), "clips", data / info, whole=True)
    acts = _object(_json(data / annotations), "act", data / annotations) if annotations else {}
    acts = {_clip_id(key): value for key, value in acts.items()}
    rows, bad = [], {}
    for key, record in records.items():
        clip_id = _clip_id(key)
        try:
            row = _row(clip_id, record, acts.get(clip_id, []))
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            bad[clip_id] = BadFile(
                data / info,
                place=f"record {key}",
                found=f"{type(error).__name__}: {error}",
                expected="ytb_id, duration and bbox, and actions with their times",
                remedy="Mend the record, or take the file again from where it was published.",
            )
        else:
            rows.append(row)
    return rows, bad


def _clip_id(key: str) -> str:
    return key.removesuffix(".mp4")


def _row(clip_id: str, record: dict, acts: list) -> dict:
    start, end = (float(record["duration"][key]) for key in ("start_sec", "end_sec"))
    if not 0 <= start < end:
        raise ValueError(f"duration from {start} to {end} s")
    box = {side: float(record["bbox"][side]) for side in ("top", "bottom", "left", "right")}
    if not (box["top"] < box["bottom"] and box["left"] < box["right"]):
        raise ValueError(f"box {box}")
    # The released file has shares of the picture, which may overshoot; the read-me shows pixels.
    in_pixels = max(box.values()) > LARGEST_SHARE
    source, subject = record["ytb_id"], record.get("subject")
    if not isinstance(source, str) or not isinstance(subject, str | None):
        raise TypeError(f"ytb_id {source!r}, subject {subject!r}")
    return {
        "clip_id": clip_id,
        "source_id": source,
        "subject_id": subject,
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
    return {
        "name": name.strip().replace(" ", "_"),
        "start_s": since,
        "end_s": until,
        "uncertainty_s": 1.0,
    }


def _seconds(time: str) -> float:
    hours, minutes, seconds = (float(part) for part in time.split(":"))
    return 3600 * hours + 60 * minutes + seconds


def _json(path: Path) -> dict:
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise unreadable(
            path,
            error,
            expected="a CelebV-Text catalogue",
            remedy="Name the file in catalogue.celebvtext, or set data_dir to its folder.",
        ) from error
    try:
        content = json.loads(text, object_pairs_hook=_no_repeats)
    except (ValueError, RecursionError) as error:
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


def _object(content: dict, key: str, path: Path, whole: bool = False) -> dict:
    """The object under key; where there is none, the whole content or nothing."""
    found = content.get(key, content if whole else {})
    if not isinstance(found, dict):
        raise BadFile(
            path,
            place=f"key {key}",
            found=type(found).__name__,
            expected="an object with an entry per clip",
            remedy="Take the file again from where it was published.",
        )
    return found


def _no_repeats(pairs: list[tuple]) -> dict:
    content = dict(pairs)
    if len(content) < len(pairs):
        keys = [key for key, _ in pairs]
        repeated = next(key for key in keys if keys.count(key) > 1)
        raise ValueError(f"key {repeated!r} twice")
    return content
