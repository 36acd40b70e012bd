"""A folder as a catalogue: each file is a source, and a clip as long as itself."""

from collections.abc import Callable, Iterable
from pathlib import Path

from mimeline.errors import MimelineError


def sources(
    paths: Iterable[Path], subject: str | None, facts: Callable[[Path], dict]
) -> tuple[list[dict], dict[str, MimelineError]]:
    """A clip for each file, and the files that cannot be read, with what is wrong with each.

    subject: the person of all files, or None. facts: what is found out about a file: end_s
    (seconds) at least; it raises MimelineError where the file cannot be read.
    Returns rows with clip_id, source_id, subject_id, start_s, actions (none) and the facts.
    """
    rows, bad = [], {}
    for path in paths:
        try:
            found = facts(path)
        except MimelineError as error:
            bad[path.stem] = error
            continue
        clip = {"clip_id": path.stem, "source_id": path.stem, "subject_id": subject}
        rows.append(clip | {"start_s": 0.0, "actions": []} | found)
    return rows, bad
