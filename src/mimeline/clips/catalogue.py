"""What exists: a catalogue, of whatever format, becomes the `clips` table, in shards."""

import hashlib
import logging
import math
import re
from collections import Counter
from collections.abc import Sequence
from fnmatch import fnmatchcase
from pathlib import Path

import pandas as pd

from mimeline import tables
from mimeline.clips.catalogues import celebvtext, videos
from mimeline.clips.catalogues.folder import sources
from mimeline.clips.failure import failure, printable
from mimeline.errors import BadFile, MimelineError
from mimeline.ledger import Ledger
from mimeline.media.limits import Limits
from mimeline.tracking.firewall import unreadable_alike
from mimeline.tracking.readers import Tracker

log = logging.getLogger(__name__)

SAFE_ID = re.compile(r"[A-Za-z0-9_-][A-Za-z0-9_.-]{0,199}")  # a plain file name


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
    may ask of us (videos).
    Raises BadFile if there is no catalogue at all.
    """
    if not Path(data).is_dir():
        raise BadFile(
            data,
            found="no such folder",
            expected="the folder of the recordings",
            remedy="Set data_dir to it, or to null for the toy world.",
        )
    if format == "celebvtext":
        rows, bad = celebvtext.read(Path(data), **options)
    elif format == "videos":
        rows, bad = videos.read(Path(data), **options, limits=Limits(**limits))
    else:
        rows, bad = _files(Path(data), tracker, **options)
    rows = [piece for row in rows for piece in _cut(row, cut_s)]
    bad = {printable(clip_id): error for clip_id, error in bad.items()}
    rows = [row | {"clip_id": printable(row["clip_id"])} for row in rows]

    ids = [*(row["clip_id"] for row in rows), *bad]
    repeated = [clip_id for clip_id, count in Counter(ids).items() if count > 1]
    if repeated:
        raise BadFile(
            data,
            found=f"clip {repeated[0]!r} twice",
            expected="a name of its own for each clip",
            remedy="Rename one of them.",
        )
    decisions = Ledger("catalogue", ids)
    for clip_id, error in bad.items():
        decisions.fail(clip_id, **failure(error))
    for row in rows:
        unsafe = [row[k] for k in ("clip_id", "source_id") if not SAFE_ID.fullmatch(row[k])]
        if unsafe:
            detail = f"{printable(unsafe[0])!r} is no plain file name: rename it (a-z 0-9 . _ -)"
            decisions.fail(row["clip_id"], "unsafe_id", detail=detail)
    kept = set(decisions.kept)
    table = pd.DataFrame(
        [row for row in rows if row["clip_id"] in kept], columns=tables.CLIPS.schema.names
    )
    for name in ("emotions", "attributes", "texts"):
        table[name] = [found if isinstance(found, list) else [] for found in table[name]]
    table["shard"] = [shard_of(source, len(clips)) for source in table["source_id"]]
    for number, path in enumerate(clips):
        tables.write(tables.CLIPS, table[table["shard"] == number], path)
    decisions.close(ledger, table["clip_id"])
    decisions.tell(log)


def shard_of(source_id: str, shards: int) -> int:
    """The shard of a source video: stable, whatever else the catalogue holds."""
    return int.from_bytes(hashlib.sha256(source_id.encode()).digest()[:8]) % shards


def _files(
    data: Path,
    tracker: dict,
    pattern: str,
    exclude: list[str],
    subject: str | None,
    subject_pattern: str | None,
) -> tuple[list[dict], dict[str, MimelineError]]:
    """Each take of the tracker's folder is a source; its tracking result tells how long it is."""
    results = Tracker.of(data, **tracker)
    paths = [
        path
        for path in results.takes()
        if fnmatchcase(path.name, pattern) and path.name not in exclude
    ]
    if not paths:
        raise BadFile(
            results.folder,
            found=f"no {results.reader.convention.title} among {pattern}",
            expected="at least one take",
            remedy="Check data_dir, the tracker's folder and catalogue.files.pattern.",
        )

    def facts(path: Path) -> dict:
        take = results.read(path)
        return {"end_s": float(len(take.motion) / take.fps)}

    def person(name: str) -> str | None:
        found = re.search(subject_pattern, name) if subject_pattern else None
        return found[0] if found else subject

    rows, bad = sources(paths, person, facts)
    if fault := unreadable_alike(bad, len(paths), results.folder) or _all_bad(rows, bad):
        raise fault
    return rows, bad


def _all_bad(rows: list[dict], bad: dict[str, MimelineError]) -> MimelineError | None:
    """What to stop with where no take could be read: the first one's error."""
    if rows:
        return None
    first = next(iter(bad.values()))
    place = f"{first.place}; none of the {len(bad)} takes can be read" if len(bad) > 1 else ""
    return BadFile(
        first.file,
        place=place.removeprefix("; ") or first.place,
        found=first.found,
        expected=first.expected,
        remedy=first.remedy,
    )


def _cut(row: dict, cut_s: float | None) -> list[dict]:
    """The take as consecutive clips of cut_s seconds; the last one is what remains."""
    length = row["end_s"] - row["start_s"]
    if cut_s is None or length <= cut_s:
        return [row]
    pieces = []
    for number in range(math.ceil(round(length / cut_s, 6))):
        since = row["start_s"] + number * cut_s
        until = min(since + cut_s, row["end_s"])
        actions = [
            act | {"start_s": max(a, 0.0), "end_s": min(b, until - since)}
            for act in row["actions"]
            if (b := act["end_s"] - number * cut_s) > 0
            and (a := act["start_s"] - number * cut_s) < until - since
        ]
        piece = {"clip_id": f"{row['clip_id']}_{number:03d}", "start_s": since, "end_s": until}
        pieces.append(row | piece | {"actions": actions})
    return pieces
