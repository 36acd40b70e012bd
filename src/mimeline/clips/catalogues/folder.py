"""A folder as a catalogue: each file or folder in it is a source, and a clip as long as itself."""

from collections.abc import Callable, Iterable
from pathlib import Path

from mimeline.errors import MimelineError


def sources(
    paths: Iterable[Path],
    subject: Callable[[str], str | None],
    facts: Callable[[Path], dict],
) -> tuple[list[dict], dict[str, MimelineError]]:
    """A clip for each path, and the paths that cannot be read, with what is wrong with each.

    subject: the person of a source's name, or None. facts: what is found out about a file: end_s
    (seconds) at least; it raises MimelineError where the file cannot be read.
    Returns rows with clip_id, source_id, subject_id, start_s, actions (none) and the facts.
    """
    rows, bad = [], {}
    for path in paths:
        name = name_of(path)
        try:
            found = facts(path)
        except MimelineError as error:
            bad[name] = error
            continue
        clip = {"clip_id": name, "source_id": name, "subject_id": subject(name)}
        rows.append(clip | {"start_s": 0.0, "actions": []} | found)
    return rows, bad


def name_of(path: Path) -> str:
    """A source's name: a file's without its ending, a folder's as it is."""
    return path.name if path.is_dir() else path.stem
