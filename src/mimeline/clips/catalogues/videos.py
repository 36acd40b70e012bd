"""A folder of bare videos as a catalogue: each video is a source, and nothing else is known."""

import logging
from collections.abc import Iterable
from pathlib import Path

from mimeline.clips.catalogues.folder import sources
from mimeline.errors import BadFile, MimelineError
from mimeline.media.limits import Limits
from mimeline.media.probe import probe

log = logging.getLogger(__name__)

ENDINGS = (".mp4", ".m4v", ".mov", ".mkv", ".webm", ".avi", ".ts", ".mts", ".m2ts")  # first wins


def read(
    data: Path,
    folder: str,
    pattern: str,
    exclude: list[str],
    subject: str | None,
    limits: Limits,
) -> tuple[list[dict], dict[str, MimelineError]]:
    """Each video of <data>/<folder> as a clip as long as itself, and those that cannot be read.

    pattern: which files are looked at. exclude: file names to leave out. Of these, the videos are
    taken as `videos_in` takes them. subject: the person of all videos, or None. limits: of a video.
    Returns rows with clip_id, source_id, subject_id, start_s, end_s, width, height and no actions,
    and clip_id → what is wrong with it. Raises BadFile if there is no video at all.
    """
    place = Path(data) / folder
    videos = _by_name(path for path in place.glob(pattern) if path.name not in exclude)
    if not videos:
        raise BadFile(
            place,
            found=f"no video among the files {pattern}",
            expected=f"files that end in {', '.join(ENDINGS)}",
            remedy="Check data_dir, catalogue.videos.folder and catalogue.videos.pattern.",
        )

    def facts(path: Path) -> dict:
        video = probe(path, limits)
        return {"end_s": video.duration_s, "width": video.width, "height": video.height}

    return sources(videos.values(), lambda _: subject, facts)


def videos_in(folder: Path) -> dict[str, Path]:
    """Name without ending → video, for every video that lies in a folder; none if there is none.

    Of several videos of one name, the ending that stands first in ENDINGS counts. Names that begin
    with a dot are passed over: systems keep their own notes in them.
    """
    if not folder.is_dir():
        log.warning("no folder %s: no clip has a video", folder)
        return {}
    return _by_name(folder.iterdir())


def _by_name(paths: Iterable[Path]) -> dict[str, Path]:
    """Name without ending → the one video of that name that counts, in the names' order."""
    videos = [p for p in paths if p.suffix.lower() in ENDINGS and not p.name.startswith(".")]
    videos.sort(key=lambda path: (path.stem, ENDINGS.index(path.suffix.lower()), path.name))
    found: dict[str, Path] = {}
    for path in videos:
        found.setdefault(path.stem, path)
    return found
