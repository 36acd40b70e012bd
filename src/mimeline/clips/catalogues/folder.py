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
    if ".." in Path(folder).parts or not lies_in(place, data):
        raise BadFile(
            place,
            found="a folder outside of data_dir",
            expected="one that lies in it",
            remedy=f"Set data_dir to a folder that holds it, and check {key}.",
        )
    return place


def files_below(place: Path, data: Path) -> tuple[list[Path], Bad]:
    """Every file below a folder, in the order of their paths, and the folders not gone into.

    Hidden names are passed over: systems keep their own notes in them. A link to a folder that
    lies in data, the user's folder, is followed.
    """
    files, bad, entered, waiting = [], [], set(), [place]
    while waiting:
        folder = waiting.pop()
        try:
            inside(folder, data)
            if (real := folder.resolve()) in entered:
                continue  # a link led back
            entered.add(real)
            for path in folder.iterdir():
                if not path.name.startswith("."):
                    (waiting if path.is_dir() else files).append(path)
        except OSError as error:
            fault = unreadable(folder, error, expected="a folder", remedy="Check its permissions.")
            bad.append((folder.relative_to(place).as_posix(), fault))
        except MimelineError as error:
            bad.append((folder.relative_to(place).as_posix(), error))
    return sorted(files), sorted(bad, key=lambda pair: pair[0])


def inside(path: Path, data: Path) -> str:
    """The path relative to data, the user's folder, as tables keep it.

    Raises BadFile where a link leads out of the folder, or the name is no Unicode.
    """
    if not lies_in(path, data):
        raise BadFile(
            path,
            found="a path or a link that leads out of data_dir",
            expected="what lies in it",
            remedy="Put the files themselves there, or set data_dir to a folder that holds both.",
        )
    name = path.relative_to(data).as_posix()
    try:
        name.encode()
    except UnicodeEncodeError as error:
        raise BadFile(
            path, found="a name that is no Unicode", expected="UTF-8", remedy="Rename it."
        ) from error
    return name


def lies_in(path: Path, data: Path) -> bool:
    """Whether a path, with all its links followed, lies in a folder."""
    try:
        return Path(path).resolve().is_relative_to(Path(data).resolve())
    except (OSError, RuntimeError, ValueError):  # a loop of links, a name with NUL
        return False
