"""CelebV-Text's catalogue: clips as JSON, actions with whole-second times of the source video."""

import logging
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from mimeline.clips.catalogues.annotations import match, read_annotations
from mimeline.clips.catalogues.json_records import (
    AGAIN,
    GARBLED,
    clip_name,
    few,
    name,
    pairs_of,
    part,
    read_object,
    seconds,
    unfit,
    whole_clip,
)
from mimeline.clips.catalogues.texts import read_texts
from mimeline.clips.intervals import Interval, outside_clip, placed
from mimeline.errors import BadFile, MimelineError

log = logging.getLogger(__name__)

EXPECTED = "a CelebV-Text catalogue"
RECORD = "ytb_id, duration and bbox, and actions with their times"
GROUPS = ("clips", "clips_set1", "clips_set2")
UNCERTAIN_S = 1.0  # the annotations tell whole seconds
TOLD = 3  # names in a line of the log
FLAGS = ("true", "yes", "1")


def read(
    data: Path, info: str, annotations: str | None, texts: Sequence[str] = ()
) -> tuple[list[dict], list[tuple[str, MimelineError]]]:
    """Clips of a catalogue, and the records that are none, each with its id and what is wrong.

    data: the folder that info and annotations (file names) and texts (folders) lie in.
    Returns rows with clip_id, source_id, subject_id, start_s, end_s, bbox_*, width, height (absent
    where the box is in shares of the picture), actions and emotions in seconds of the clip,
    attributes, texts, and notes: what the ledger says of the clip, a list of (rule, facts).
    Raises BadFile if a file is no catalogue.
    """
    told = read_annotations(data / annotations) if annotations else {}
    rows, bad = [], []
    for clip_id, key, record in _records(read_object(data / info, EXPECTED), data / info):
        try:
            rows.append({"clip_id": clip_id, "name": clip_name(key)} | whole_clip(record))
        except GARBLED as error:
            bad.append((clip_id, unfit(data / info, key, error, RECORD)))
    rows, repeated = _first_of_each_id(rows)
    if texts:
        names, starts = [row["name"] for row in rows], [row["start_s"] for row in rows]
        for row, lines in zip(rows, read_texts(data, texts, names, starts), strict=True):
            row["texts"] = lines
    if annotations:
        rows, unfit_told = _annotated(rows, told, data / annotations)
        bad += unfit_told
        repeated = [row | _untold("its id stands in the catalogue before") for row in repeated]
    return rows + repeated, bad


def _records(content: dict[str, Any], path: Path) -> Iterator[tuple[str, str, Any]]:
    """Clip id, key and record of each; of a later set, ids that an earlier one has end in _set2."""
    if "meta_info" in content:
        raise BadFile(
            path,
            found="meta_info, as in a CelebV-HQ catalogue",
            expected=EXPECTED,
            remedy="Set catalogue.format to celebvhq, and catalogue.celebvhq.info to the file.",
        )
    if not any(group in content for group in GROUPS):
        yield from ((clip_name(key), key, record) for key, record in pairs_of(content))
        return
    earlier: set[str] = set()
    for group, records in pairs_of(content):
        if group not in GROUPS:
            log.warning("%s: passed over %s, which is no set of clips", path.name, ascii(group))
            continue
        if not isinstance(records, dict):
            raise BadFile(
                path,
                place=f"key {group}",
                found=type(records).__name__,
                expected="an object with a record per clip",
                remedy=AGAIN,
            )
        ids = [(clip_name(key), key, record) for key, record in pairs_of(records)]
        ending = group.removeprefix("clips")
        for clip_id, key, record in ids:
            yield (f"{clip_id}{ending}" if clip_id in earlier else clip_id), key, record
        earlier.update(clip_id for clip_id, *_ in ids)


def _first_of_each_id(rows: list[dict]) -> tuple[list[dict], list[dict]]:
    """The rows whose names can be looked up, and those whose ids repeat."""
    first: dict[str, dict] = {}
    repeated = [row for row in rows if first.setdefault(row["clip_id"], row) is not row]
    return list(first.values()), repeated


def _annotated(
    rows: list[dict], told: dict[str, dict[str, Any]], path: Path
) -> tuple[list[dict], list[tuple[str, MimelineError]]]:
    """The rows with what is told of them, and those of which that cannot be read."""
    every = dict.fromkeys(key for entries in told.values() for key in entries)
    starts = [row["start_s"] for row in rows]
    keys, doubts = match([row["name"] for row in rows], starts, every)
    good, bad = [], []
    for row, key, doubt in zip(rows, keys, doubts, strict=True):
        if key is None:
            why = "several fit its name in part: none is taken" if doubt else "none of its name"
            good.append(row | _untold(why))
            continue
        entries = {kind: found[key] for kind, found in told.items() if key in found}
        try:
            good.append(row | _told(entries, row["start_s"], row["end_s"]))
        except GARBLED as error:
            bad.append((row["clip_id"], unfit(path, key, error, "names, with times as h:mm:ss")))
    doubtful = [row["name"] for row, doubt in zip(rows, doubts, strict=True) if doubt]
    _log(path.name, keys, doubtful, len(every), [n for row in good for n in row.get("notes", [])])
    return good, bad


def _untold(why: str) -> dict[str, Any]:
    return {"notes": [("no_annotations", {"detail": why})]}


def _log(
    file: str, keys: list[str | None], doubtful: list[str], told: int, notes: list[tuple[str, dict]]
) -> None:
    known = len(keys) - keys.count(None)
    log.info("%s: %d of %d clips are annotated", file, known, len(keys))
    if told > known:
        log.info("%s: %d annotations are of no clip in the catalogue", file, told - known)
    if doubtful:
        names = ", ".join(ascii(n)[1:-1] for n in doubtful[:TOLD])
        log.warning("%s: whose they are is in doubt for %d clips: %s", file, len(doubtful), names)
    for rule, what in (
        ("outside_clip", "intervals outside of their clips are left out"),
        ("attributes_in_part", "attributes that hold for a part of their clips are left out"),
    ):
        facts = [facts for noted, facts in notes if noted == rule]
        if facts:
            n = sum(fact["value"] for fact in facts)
            log.warning("%s: %d %s, of %d clips", file, n, what, len(facts))


def _told(entries: dict[str, Any], start: float, end: float) -> dict[str, Any]:
    """actions, emotions and attributes of a clip, and notes on what was left out."""
    actions, outside = _placed(entries.get("act", ()), start, end)
    emotions, beside = _placed(entries.get("emotion", ()), start, end)
    attributes, partly = _attributes(entries.get("app", {}), start, end)
    notes = outside_clip(outside + beside)
    if partly:
        facts = {"value": len(partly), "unit": "attributes", "detail": "; ".join(partly)}
        notes.append(("attributes_in_part", facts))
    return {"actions": actions, "emotions": emotions, "attributes": attributes, "notes": notes}


def _placed(entries: Any, start: float, end: float) -> tuple[list[Interval], list[str]]:
    """[[name, [from, to, duration, order]], ...], absolute h:mm:ss → seconds within the clip."""
    told = [
        (name(label), seconds(since) - start, seconds(until) - start)
        for label, (since, until, *_) in few(entries)
    ]
    return placed(told, end - start, UNCERTAIN_S)


def _attributes(app: Any, start: float, end: float) -> tuple[list[str], list[str]]:
    """What is set for the whole clip, as `lighting:frontal` or `mole`; and what for part of it.

    app: attribute → values. A value is a text, empty where the attribute is not set, or a text
    with its times, [from, to, duration].
    """
    whole: dict[str, None] = {}
    partly: dict[str, None] = {}
    for label, values in part(app).items():
        for value in few(values):
            if value == "":
                continue
            text, *times = value if isinstance(value, list | tuple) else (value,)
            holds = whole if all(_covers(t, start, end) for t in times) else partly
            holds[_attribute(name(label), name(text))] = None
    return list(whole), [attribute for attribute in partly if attribute not in whole]


def _covers(times: Any, start: float, end: float) -> bool:
    since, until, *_ = times
    return seconds(since) <= start + UNCERTAIN_S and seconds(until) >= end - UNCERTAIN_S


def _attribute(label: str, value: str) -> str:
    return label if value in (label, *FLAGS) else f"{label}:{value}"
