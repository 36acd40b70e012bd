"""A folder of bare videos as a catalogue: each video is a source, and nothing else is known."""

import logging
from pathlib import Path

from mimeline.clips.catalogues.films import (
    ENDINGS,
    film_facts,
    is_film,
    no_film,
    one_of_a_name,
)
from mimeline.clips.catalogues.folder import Bad, clips_of, folder_in
from mimeline.media.limits import Limits
from mimeline.progress import told

__all__ = ["ENDINGS", "read", "videos_in"]

log = logging.getLogger(__name__)


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
    actions, and the videos that are none. Raises BadFile if there is no video at all.
    """
    data = Path(data)
    place = folder_in(data, folder, "catalogue.videos.folder")
    paths = [path for path in place.glob(pattern) if path.name not in exclude]
    films = one_of_a_name(path for path in paths if is_film(path) and not _hidden(path, place))
    if not films:
        remedy = "Check catalogue.videos.folder, pattern and exclude."
        raise no_film(place, paths, remedy)

    def facts(path: Path) -> dict:
        return film_facts(path, data, limits) | {"subject_id": subject}

    return clips_of(
        ((joined(path.relative_to(place)), path) for path in told(films, "videos", log)), facts
    )


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


def _hidden(path: Path, place: Path) -> bool:
    return any(part.startswith(".") for part in path.relative_to(place).parts)
