"""Video files of a folder: which of them count, and how long each is."""

from collections.abc import Iterable
from pathlib import Path

from mimeline.clips.catalogues.folder import Bad, files_below, folder_in
from mimeline.errors import BadFile
from mimeline.media.limits import Limits
from mimeline.media.probe import probe

ENDINGS = (".mp4", ".m4v", ".mov", ".mkv", ".webm", ".avi", ".ts", ".mts", ".m2ts")  # first wins


def is_film(path: Path) -> bool:
    """Whether a file is named as a video, and is no note of a system."""
    return path.suffix.lower() in ENDINGS and not path.name.startswith(".")


def films_below(data: Path, folder: str, key: str) -> tuple[list[Path], Bad]:
    """The videos below <data>/<folder>, in the order of their paths, and folders not gone into.

    key: the one that names the folder. Raises BadFile if there is no video at all.
    """
    place = folder_in(data, folder, key)
    files, bad = files_below(place)
    films = [path for path in files if is_film(path)]
    if not films and not bad:
        raise no_film(place, files, f"Check data_dir and {key}.")
    return films, bad


def no_film(place: Path, files: Iterable[Path], remedy: str) -> BadFile:
    """The error for a folder without videos: of archives, that they are to be unpacked."""
    archives = sorted(p.name for p in files if p.suffix.lower() in (".tar", ".zip", ".gz"))
    return BadFile(
        place,
        found=f"no video, but {archives[0]}" if archives else "no video",
        expected=f"files that end in {', '.join(ENDINGS)}",
        remedy=f"Unpack {', '.join(archives[:3])}." if archives else remedy,
    )


def one_of_a_name(films: Iterable[Path]) -> list[Path]:
    """Of several videos of one name in a folder the ending that stands first in ENDINGS."""
    found: dict[Path, Path] = {}
    for path in sorted(films, key=lambda p: (ENDINGS.index(p.suffix.lower()), p.name)):
        found.setdefault(path.with_suffix(""), path)
    return [found[name] for name in sorted(found)]


def film_facts(path: Path, data: Path, limits: Limits) -> dict:
    """end_s, width, height and video (relative to data) of a video, from a look into it.

    Raises BadFile where it cannot be read, Refused beyond the limits.
    """
    found = probe(path, limits)
    return {
        "video": path.relative_to(data).as_posix(),
        "end_s": found.duration_s,
        "width": found.width,
        "height": found.height,
    }


def unfit(path: Path, count: int, expected: str, key: str) -> BadFile:
    """The error for a video, the first of count, whose name does not tell what it shows.

    key: the one that names the folder.
    """
    many = f"none of {count} videos" if count > 1 else "a video that is not"
    return BadFile(
        path,
        found=f"{many} named as the format is",
        expected=expected,
        remedy=f"Rename it, move it elsewhere, or check {key} and catalogue.format.",
    )
