"""Catalogues of clips, as the stage catalogue would see them."""

import re
from collections import Counter
from pathlib import Path

from mimeline.clips.admission import fault_of, judged
from mimeline.clips.catalogues import celebvhq, celebvtext, table
from mimeline.clips.catalogues.annotations import read_annotations
from mimeline.clips.exclusions import read_exclusions
from mimeline.clips.failure import failure
from mimeline.errors import MimelineError
from mimeline.inspection.files import columns_of, glance
from mimeline.inspection.inspection import Inspection
from mimeline.inspection.options import Options
from mimeline.media.limits import Limits

CELEBVTEXT, CELEBVHQ = "CelebV-Text catalogue", "CelebV-HQ catalogue"
ANNOTATIONS = "CelebV-Text annotations"
CLIPS, EXCLUSIONS = "table of clips", "list of exclusions"
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
    _judge(seen, records, bad)
    if kind == CELEBVTEXT and seen.facts and not any("width" in row for row in records):
        seen.notes.append(
            "boxes are in shares of the picture: sizes show when the videos are there"
        )
    return seen


def table_of_clips(path: Path, options: Options) -> Inspection | None:
    """A table as catalogue.format: table reads it, or a list of exclusions; else None.

    Videos are looked for under data_dir, where a configuration names it, else beside the table.
    """
    kind = list_kind(path)
    if kind is None:
        return None
    seen = Inspection(path, kind)
    data, inside = options.data.absolute(), path.absolute()
    if options.data == Path() or not inside.is_relative_to(data):
        data = inside.parent
    try:
        if kind == EXCLUSIONS:
            reasons = read_exclusions(path)
            seen.numbers = {"clips": len(reasons)}
            counts = Counter(reasons.values()).most_common(TOLD)
            told = ", ".join(f"{reason or 'none told'} {count}" for reason, count in counts)
            seen.facts = {"clips": str(len(reasons)), "reasons": told}
            return seen
        records, bad = table.read(data, inside.relative_to(data).as_posix(), Limits())
    except MimelineError as error:
        seen.error = str(error)
        return seen
    _judge(seen, records, bad)
    return seen


def list_kind(path: Path) -> str | None:
    """Whether a table is one of clips or of exclusions, by its columns; a run's own is neither."""
    if path.suffix.lower() == ".csv":
        header = glance(path).partition(b"\n")[0].decode("utf-8-sig", errors="replace")
        columns = {cell.strip(' "\r').casefold() for cell in re.split("[,;\t]", header)}
    elif path.suffix.lower() == ".parquet":
        columns = set(columns_of(path))
    else:
        return None
    if "clip_id" not in columns or "shard" in columns:
        return None
    if columns & {"video", "source_id", "start_s", "end_s"}:
        return CLIPS
    return EXCLUSIONS if "reason" in columns and path.suffix.lower() == ".csv" else None


def _judge(seen: Inspection, records: list[dict], bad: list[tuple[str, MimelineError]]) -> None:
    """What a run would make of the records: the clips, and those that are none."""
    entries = [(row["clip_id"], fault_of(row) or row) for row in records]
    found = judged(entries + [(clip_id, failure(error)) for clip_id, error in bad])
    problems = [f"{name}: {entry['detail']}" for name, entry in found if "rule" in entry]
    seen.problems += problems[:TOLD]
    if len(problems) > TOLD:
        seen.problems.append(f"and {len(problems) - TOLD:,} more")
    rows = [entry for _, entry in found if "rule" not in entry]
    if not rows:
        return
    seconds = [row["end_s"] - row["start_s"] for row in rows]
    seen.numbers = {"clips": len(rows), "sources": len({row["source_id"] for row in rows})}
    seen.facts = {
        "clips": f"{len(rows)}, from {seen.numbers['sources']} sources",
        "length": f"{min(seconds):.1f} to {max(seconds):.1f} s, {sum(seconds) / 60:.1f} min in all",
    }
    for what in ("actions", "emotions", "attributes"):
        if told := sum(bool(row.get(what)) for row in rows):
            seen.facts[what] = f"of {told} clips"


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
