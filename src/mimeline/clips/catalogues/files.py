"""A tracker's folder as a catalogue: each take is a source, and as long as its result."""

import logging
import re
from fnmatch import fnmatchcase
from pathlib import Path

from mimeline.clips.catalogues.folder import Bad, clips_of, name_of
from mimeline.errors import BadFile, MimelineError
from mimeline.progress import told
from mimeline.tracking.firewall import unreadable_alike
from mimeline.tracking.readers import Tracker

log = logging.getLogger(__name__)


def read(
    data: Path,
    tracker: dict,
    pattern: str,
    exclude: list[str],
    subject: str | None,
    subject_pattern: str | None,
) -> tuple[list[dict], Bad]:
    """Each take of the tracker's folder as a clip, and those that cannot be read.

    data: the user's folder. tracker: format, options and bad_values of the takes' reader.
    pattern: which of its files, or of its folders, are takes. exclude: names to leave out.
    subject: the person of all takes. subject_pattern: what it finds in a take's name is its person.
    Returns rows with clip_id, source_id, subject_id, start_s, end_s and no actions, and the takes
    that cannot be read, each with what is wrong.
    Raises BadFile if there is no take, if none can be read, or if one key mends most of them.
    """
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
        return {"end_s": float(len(take.motion) / take.fps), "subject_id": person(name_of(path))}

    def person(name: str) -> str | None:
        found = re.search(subject_pattern, name) if subject_pattern else None
        return (found and found[0]) or subject

    rows, bad = clips_of(((name_of(path), path) for path in told(paths, "takes", log)), facts)
    if fault := unreadable_alike(dict(bad), len(paths), results.folder) or _all_bad(rows, bad):
        raise fault
    return rows, bad


def _all_bad(rows: list[dict], bad: Bad) -> MimelineError | None:
    """What to stop with where no take could be read: the first one's error."""
    if rows:
        return None
    first = bad[0][1]
    place = f"{first.place}; none of the {len(bad)} takes can be read" if len(bad) > 1 else ""
    return BadFile(
        first.file,
        place=place.removeprefix("; ") or first.place,
        found=first.found,
        expected=first.expected,
        remedy=first.remedy,
    )
