"""A folder of bare videos as a catalogue: each video is a source, and nothing else is known."""

import logging
from collections.abc import Sequence
from fnmatch import fnmatchcase
from pathlib import Path, PurePosixPath

from mimeline.clips.catalogues.films import (
    ENDINGS,
    film_facts,
    is_film,
    no_film,
    one_of_a_name,
)
from mimeline.clips.catalogues.folder import Bad, clips_of, files_below, folder_in
from mimeline.media.limits import Limits
from mimeline.progress import told

__all__ = ["ENDINGS", "read", "videos_in"]

log = logging.getLogger(__name__)

ANY = "**"  # in a pattern: however many folders


def read(
    data: Path,
    folder: str,
    pattern: str,
    exclude: list[str],
    subject: str | None,
    limits: Limits,
) -> tuple[list[dict], Bad]:
    """Each video of <data>/<folder> as a clip as long as itself, and those that cannot be read.

    pattern: which files are looked at, of folders below too where it says so. exclude: file names
    to leave out. Of these, the videos are taken as `videos_in` takes them; one of a folder below
    bears that folder's name, too. subject: the person of all videos, or None. limits: of a video.
    Returns rows with clip_id, source_id, subject_id, start_s, end_s, width, height, video and no
    actions, and the videos that are none and folders that cannot be gone into. Raises BadFile if
    there is no video at all.
    """
    data = Path(data)
    place = folder_in(data, folder, "catalogue.videos.folder")
    parts = PurePosixPath(pattern).parts
    files, bad = files_below(place, depth=None if ANY in parts else len(parts) - 1)
    paths = [
        path
        for path in files
        if _fits(path.relative_to(place).parts, parts) and path.name not in exclude
    ]
    films = one_of_a_name(filter(is_film, paths))
    if not films and not bad:
        remedy = "Check catalogue.videos.folder, pattern and exclude."
        raise no_film(place, paths, remedy)

    def facts(path: Path) -> dict:
        return film_facts(path, data, limits) | {"subject_id": subject}

    rows, unread = clips_of(
        ((joined(path.relative_to(place)), path) for path in told(films, "videos", log)), facts
    )
    return rows, bad + unread


def joined(path: Path) -> str:
    """A video's name, of its folders and its own without its ending."""
    return "_".join((*path.parent.parts, path.stem))


def videos_in(folder: Path) -> dict[str, Path]:
    """Name without ending → video, for every video that lies in a folder; none if there is none.

    Of several videos of one name, the ending that stands first in ENDINGS counts. Names that begin
    with a dot are passed over: systems keep their own notes in them.
    """
    if not folder.is_dir():
        log.warning("no folder %s: no clip has a video", folder)
        return {}
    return {path.stem: path for path in one_of_a_name(filter(is_film, folder.iterdir()))}


def _fits(names: Sequence[str], pattern: Sequence[str]) -> bool:
    """Whether a path's names fit a pattern's, one each; ** stands for any number of them."""
    if not pattern:
        return not names
    first, *rest = pattern
    if first == ANY:
        return any(_fits(names[n:], rest) for n in range(len(names) + 1))
    return bool(names) and fnmatchcase(names[0], first) and _fits(names[1:], rest)
