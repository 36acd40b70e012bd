"""A folder as a catalogue: what lies in it, and a clip for each file that can be read."""

from collections.abc import Callable, Iterable
from pathlib import Path

from mimeline.errors import BadFile, MimelineError, NoSuchFile, unreadable

Bad = list[tuple[str, MimelineError]]  # a record's name and why it is none


def clips_of(
    named: Iterable[tuple[str, Path]], facts: Callable[[Path], dict]
) -> tuple[list[dict], Bad]:
    """A clip for each named file, as long as itself, and the files that cannot be read.

    facts: what is found out about a file: end_s (seconds) at least; it raises MimelineError where
    the file cannot be read.
    Returns rows with clip_id, source_id, start_s, actions (none) and the facts.
    """
    rows, bad = [], []
    for name, path in named:
        try:
            found = facts(path)
        except MimelineError as error:
            bad.append((name, error))
            continue
        rows.append({"clip_id": name, "source_id": name, "start_s": 0.0, "actions": []} | found)
    return rows, bad


def name_of(path: Path) -> str:
    """A source's name: a file's without its ending, a folder's as it is."""
    return path.name if path.is_dir() else path.stem


def folder_in(data: Path, folder: str, key: str) -> Path:
    """<data>/<folder>. key: the one that names it.

    Raises NoSuchFile, or BadFile where it does not lie in the user's folder.
    """
    place = Path(data) / folder
    remedy = f"Check data_dir and {key}."
    if not place.is_dir():
        raise NoSuchFile(place, found="no such folder", expected="a folder", remedy=remedy)
    if not lies_in(place, data):
        raise BadFile(
            place,
            found="a folder outside of data_dir",
            expected="one that lies in it",
            remedy=f"Set data_dir to a folder that holds it, or put a link to it into data_dir, "
            f"and check {key}.",
        )
    return place


def files_below(place: Path, depth: int | None = None) -> tuple[list[Path], Bad]:
    """Every file below a folder, in the order of their paths, and the folders not gone into.

    depth: of folders in folders; None: however many. Hidden names are passed over: systems keep
    their own notes in them. Links are followed. A folder that has several names is gone into once,
    by a name without links where it has one.
    """
    files, bad, entered = [], [], set()
    waiting, linked = [place], []
    while waiting or linked:
        folder = waiting.pop() if waiting else linked.pop(0)
        try:
            if (real := folder.resolve()) in entered:
                continue
            entered.add(real)
            inner = depth is None or len(folder.relative_to(place).parts) < depth
            for path in sorted(folder.iterdir()):
                if path.name.startswith("."):
                    continue
                if not path.is_dir():
                    files.append(path)
                elif inner:
                    (linked if path.is_symlink() else waiting).append(path)
        except OSError as error:
            fault = unreadable(folder, error, expected="a folder", remedy="Check its permissions.")
            bad.append((folder.relative_to(place).as_posix(), fault))
    return sorted(files), sorted(bad, key=lambda pair: pair[0])


def lies_in(path: Path, data: Path) -> bool:
    """Whether a path is one below a folder by its names; links in it may lead anywhere."""
    try:
        return ".." not in Path(path).relative_to(data).parts and "\0" not in str(path)
    except ValueError:
        return False
