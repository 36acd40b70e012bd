"""A folder of bare videos as a catalogue: each video is a source, and nothing else is known."""

import logging
from pathlib import Path

from mimeline.clips.folder import sources
from mimeline.errors import BadFile
from mimeline.media.limits import Limits
from mimeline.media.probe import probe

log = logging.getLogger(__name__)

ENDINGS = (".mp4", ".m4v", ".mov", ".mkv", ".webm", ".avi", ".ts", ".mts", ".m2ts")  # first wins

TOLD_EVERY = 200  # videos, about half a minute's work


def read(
    data: Path,
    folder: str,
    pattern: str,
    exclude: list[str],
    subject: str | None,
    limits: Limits,
) -> tuple[list[dict], dict[str, str]]:
    """Each video of <data>/<folder> as a clip as long as itself, and those that cannot be read.

    pattern: which files are looked at; of these, the videos by their name's ending. exclude: file
    names to leave out. subject: the person of all videos, or None. limits: of a video.
    Returns rows with clip_id, source_id, subject_id, start_s, end_s, width, height and no actions,
    and clip_id → what is wrong with it. Raises BadFile if there is no video at all.
    """
    place = Path(data) / folder
    paths = sorted(
        path
        for path in place.glob(pattern)
        if path.suffix.lower() in ENDINGS and path.name not in exclude
    )
    if not paths:
        raise BadFile(
            place,
            found=f"no video among the files {pattern}",
            expected=f"files that end in {', '.join(ENDINGS)}",
            remedy="Check data_dir, catalogue.videos.folder and catalogue.videos.pattern.",
        )

    def facts(path: Path) -> dict:
        video = probe(path, limits)
        return {"end_s": video.duration_s, "width": video.width, "height": video.height}

    return sources(paths, subject, facts)


def videos_in(folder: Path) -> dict[str, Path]:
    """Name without ending → video, for every video that lies in a folder; none if there is none.

    Of several videos of one name, the ending that stands first in ENDINGS counts.
    """
    if not folder.is_dir():
        log.warning("no folder %s: no clip has a video", folder)
        return {}
    found = {}
    for path in sorted(folder.iterdir()):
        ending = path.suffix.lower()
        if ending in ENDINGS:
            other = found.get(path.stem)
            if other is None or ENDINGS.index(ending) < ENDINGS.index(other.suffix.lower()):
                found[path.stem] = path
    return found
