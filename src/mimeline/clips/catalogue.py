"""What exists: a catalogue, of whatever format, becomes the `clips` table, in shards."""

import gc
import hashlib
import logging
import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import pandas as pd

from mimeline import tables
from mimeline.clips.admission import fault_of, judged
from mimeline.clips.catalogues import (
    celebvhq,
    celebvtext,
    mead,
    ravdess,
    realtalk,
    table,
    videos,
)
from mimeline.clips.failure import failure
from mimeline.clips.intervals import between, longest
from mimeline.errors import BadFile
from mimeline.ledger import Ledger
from mimeline.media.limits import Limits

log = logging.getLogger(__name__)

MOST_CLIPS = 1_000_000
IN_WRITING = {"celebvtext": celebvtext.read, "celebvhq": celebvhq.read}
IN_VIDEOS = {
    "realtalk": realtalk.read,
    "mead": mead.read,
    "ravdess": ravdess.read,
    "table": table.read,
    "videos": videos.read,
}


def catalogue(
    data: Path,
    clips: Sequence[Path],
    ledger: Path,
    format: str,
    options: dict,
    cut_s: float | None,
    tracker: dict | None,
    limits: dict | None,
) -> None:
    """Read a catalogue and write one `clips` table per shard, and the ledger.

    data: the user's folder. clips: the tables to write; a source video's clips share a shard.
    format, options: the catalogue's format and its keys. cut_s: longer takes are cut into
    consecutive clips of that many seconds. What tells how long a source is, where the catalogue
    does not: tracker, the format and options of the takes' reader (files); limits, what a video
    may ask of us (formats in which the videos tell).
    A record that is no clip is a row of the ledger: unreadable, unsafe_id, bad_times, box_outside,
    unsafe_path, repeated_id (there as <id>#2) or case_collision.
    Raises BadFile if there is no catalogue at all.
    """
    data = Path(data)
    if not data.is_dir():
        raise BadFile(
            data,
            found="no such folder",
            expected="the folder of the recordings",
            remedy="Set data_dir to it, or to null for the toy world.",
        )
    with _many_small_objects():
        if format == "files":
            from mimeline.clips.catalogues import files  # trackers' readers load slowly

            records, bad = files.read(data, tracker, **options)
        elif format in IN_VIDEOS:
            records, bad = IN_VIDEOS[format](data, **options, limits=Limits(**limits))
        else:
            records, bad = IN_WRITING[format](data, **options)
        entries = _examined(data, records, cut_s)
        entries += [(clip_id, failure(error)) for clip_id, error in bad]
        found = judged(entries)
        decisions = Ledger("catalogue", [name for name, _ in found])
        kept = _decide(decisions, found)
    _write(kept, clips)
    decisions.close(ledger, [row["clip_id"] for row in kept])
    decisions.tell(log)


def shard_of(source_id: str, shards: int) -> int:
    """The shard of a source video: stable, whatever else the catalogue holds."""
    return int.from_bytes(hashlib.sha256(source_id.encode()).digest()[:8]) % shards


@contextmanager
def _many_small_objects() -> Iterator[None]:
    """No search for cycles among objects that have none: it would take as long as the rest."""
    was = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was:
            gc.enable()


def _examined(data: Path, records: list[dict], cut_s: float | None) -> list[tuple[str, dict]]:
    """Each clip's id and row; of a record that may not become one, its id and its fault."""
    entries: list[tuple[str, dict]] = []
    for record in records:
        if fault := fault_of(record):
            entries.append((record["clip_id"], fault))
            continue
        pieces = _pieces(record, cut_s)
        if len(entries) + pieces > MOST_CLIPS:
            raise BadFile(
                data,
                found=f"more than {MOST_CLIPS:,} clips",
                expected="fewer",
                remedy="Set catalogue.cut_s to more seconds, or take a part of the catalogue.",
            )
        entries += [(row["clip_id"], row) for row in _cut(record, cut_s, pieces)]
    return entries


def _decide(decisions: Ledger, found: list[tuple[str, dict]]) -> list[dict]:
    """The rows that are clips; the ledger says what became of the others."""
    kept = []
    for name, entry in found:
        if "rule" in entry:
            decisions.fail(name, **entry)
            continue
        for rule, facts in entry.get("notes", ()):
            decisions.note(name, rule, **facts)
        kept.append(entry)
    return kept


def _write(rows: list[dict], clips: Sequence[Path]) -> None:
    """The table's shards, an empty one where no source falls into it."""
    found = pd.DataFrame(rows, columns=tables.CLIPS.schema.names)
    for name in ("actions", "emotions", "attributes", "texts"):
        found[name] = [told if isinstance(told, list) else [] for told in found[name]]
    shard = {source: shard_of(source, len(clips)) for source in found["source_id"].unique()}
    found["shard"] = found["source_id"].map(shard)
    shards = dict(iter(found.groupby("shard")))
    for number, path in enumerate(clips):
        tables.write(tables.CLIPS, shards.get(number, found.iloc[:0]), path)


def _pieces(row: dict, cut_s: float | None) -> int:
    """How many clips the take is cut into."""
    length = row["end_s"] - row["start_s"]
    return 1 if cut_s is None else math.ceil(round(length / cut_s, 6))


def _cut(row: dict, cut_s: float | None, pieces: int) -> Iterator[dict]:
    """The take as consecutive clips of cut_s seconds; the last one is what remains."""
    emotion = row.get("emotion") or longest(row.get("emotions") or ())
    if pieces <= 1:
        yield row | {"emotion": emotion}
        return
    for number in range(pieces):
        since = number * cut_s
        until = min(since + cut_s, row["end_s"] - row["start_s"])
        last = number == pieces - 1
        piece = row | {
            "clip_id": f"{row['clip_id']}_{number:03d}",
            "start_s": row["start_s"] + since,
            "end_s": row["start_s"] + until,
            "emotion": emotion,
        }
        for told in ("actions", "emotions"):
            piece[told] = between(row.get(told) or (), since, until, last)
        if row.get("emotions"):
            piece["emotion"] = longest(piece["emotions"])
        yield piece
