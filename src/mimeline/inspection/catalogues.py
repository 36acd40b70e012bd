"""Catalogues of clips, as the stage catalogue would see them."""

import re
from pathlib import Path

from mimeline.clips.admission import fault_of, judged
from mimeline.clips.catalogues import celebvhq, celebvtext
from mimeline.clips.catalogues.annotations import read_annotations
from mimeline.clips.failure import failure
from mimeline.errors import MimelineError
from mimeline.inspection.files import glance
from mimeline.inspection.inspection import Inspection

CELEBVTEXT, CELEBVHQ = "CelebV-Text catalogue", "CelebV-HQ catalogue"
ANNOTATIONS = "CelebV-Text annotations"
TOLD_OF = re.compile(  # annotations begin with the name of their first part, in JSON or pickled
    rb'\s*\{\s*"(act|app)"\s*:\s*\{|\x80.{1,14}(\x8c\x03|X\x03\x00\x00\x00)(act|app)', re.DOTALL
)
TOLD = 10  # records of a catalogue that cannot be read


def catalogue_kind(path: Path) -> str | None:
    """Whose catalogue a JSON file looks like, by its beginning; None for any other file."""
    head = glance(path) if path.suffix.lower() in (".json", ".pkl") else b""
    if TOLD_OF.match(head):
        return ANNOTATIONS
    if b'"appearance_mapping"' in head or (b'"ytb_id"' in head and b'"sep_flag"' in head):
        return CELEBVHQ
    return CELEBVTEXT if b'"ytb_id"' in head else None


def catalogue(path: Path) -> Inspection | None:
    """A catalogue of CelebV-Text or CelebV-HQ, or annotations of the former; else None."""
    kind = catalogue_kind(path)
    if kind is None:
        return None
    if kind == ANNOTATIONS:
        return _annotations(path)
    seen = Inspection(path, kind)
    try:
        if kind == CELEBVHQ:
            records, bad = celebvhq.read(path.parent, path.name)
        else:
            records, bad = celebvtext.read(path.parent, path.name, None)
    except MimelineError as error:
        seen.error = str(error)
        return seen
    entries = [(row["clip_id"], fault_of(row) or row) for row in records]
    found = judged(entries + [(clip_id, failure(error)) for clip_id, error in bad])
    problems = [f"{name}: {entry['detail']}" for name, entry in found if "rule" in entry]
    seen.problems += problems[:TOLD]
    if len(problems) > TOLD:
        seen.problems.append(f"and {len(problems) - TOLD:,} more")
    rows = [entry for _, entry in found if "rule" not in entry]
    if not rows:
        return seen
    seconds = [row["end_s"] - row["start_s"] for row in rows]
    seen.numbers = {"clips": len(rows), "sources": len({row["source_id"] for row in rows})}
    seen.facts = {
        "clips": f"{len(rows)}, from {seen.numbers['sources']} sources",
        "length": f"{min(seconds):.1f} to {max(seconds):.1f} s, {sum(seconds) / 60:.1f} min in all",
    }
    for what in ("actions", "emotions", "attributes"):
        if told := sum(bool(row.get(what)) for row in rows):
            seen.facts[what] = f"of {told} clips"
    if kind == CELEBVTEXT and not any("width" in row for row in rows):
        seen.notes.append(
            "boxes are in shares of the picture: sizes show when the videos are there"
        )
    return seen


def _annotations(path: Path) -> Inspection:
    """What is told of clips; whether it fits them shows in a run."""
    seen = Inspection(path, ANNOTATIONS)
    try:
        told = read_annotations(path)
    except MimelineError as error:
        seen.error = str(error)
        return seen
    for part, entries in told.items():
        seen.facts[part] = f"of {len(entries)} clips"
    seen.numbers = {part: len(entries) for part, entries in told.items()}
    return seen
