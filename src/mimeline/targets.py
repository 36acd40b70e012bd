"""Where people want something written: never over what is theirs, unless they say so."""

from collections.abc import Collection, Iterable
from pathlib import Path

from mimeline.errors import BadFile


def require_free(target: Path, sources: Collection[Path], overwrite: bool) -> None:
    """Raise BadFile where target is one of the sources, is no file, or is there already; overwrite
    allows to replace a file."""
    if not target.exists():
        return
    if any(target.samefile(source) for source in sources):
        found, remedy = "the file that is read", "Name another one; what is there stays."
    elif target.is_symlink() or not target.is_file():
        found = "a folder" if target.is_dir() else "a link, or something else than a file"
        remedy = "Name a file."  # /dev/stdout is a link to a file where it goes into one
    elif not overwrite:
        found = "a file already"
        remedy = "It may be somebody's work: name another one, or say --overwrite."
    else:
        return
    raise BadFile(target, found=found, expected="another file to write to", remedy=remedy)


def is_folder(target: Path) -> bool:
    """Whether a folder is meant: one that is there, or a name without an ending."""
    return target.is_dir() or not (target.suffix or target.exists())


def require_folder(folder: Path) -> None:
    """Raise BadFile where a file stands in the folder's place."""
    if folder.exists() and not folder.is_dir():
        raise BadFile(
            folder,
            found="a file",
            expected="a folder for a file of each clip",
            remedy="Name another one.",
        )


def require_new(folder: Path, paths: Iterable[Path], overwrite: bool) -> list[Path]:
    """Those of the paths in a folder that are there. Raises BadFile for them, unless overwrite."""
    there = [path for path in paths if path.exists()]
    if there and not overwrite:
        raise BadFile(
            folder,
            found=f"{there[0].name}{f' and {len(there) - 1} more' if there[1:] else ''} already",
            expected="no file of a clip that is to be written",
            remedy="They may be somebody's work: name another folder, or say --overwrite.",
        )
    return there
