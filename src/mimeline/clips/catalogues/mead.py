"""MEAD's folders as a catalogue: who shows what, and how strongly, stands in each path.

Wang et al. 2020, MEAD: A Large-scale Audio-visual Dataset for Emotional Talking-face Generation.
"""

import logging
import re
from collections import Counter
from collections.abc import Collection
from pathlib import Path

from mimeline.clips.catalogues.films import film_facts, films_below, unfit
from mimeline.clips.catalogues.folder import Bad, clips_of
from mimeline.clips.intervals import over
from mimeline.errors import BadFile
from mimeline.media.limits import Limits
from mimeline.progress import told

log = logging.getLogger(__name__)

EXPECTED = "M003/video/front/angry/level_1/001.mp4, or M003_front_angry_level_1_001.mp4"
NAMED = re.compile(
    r"(?:.*/)?(?P<person>[MW]\d{3})(?:_video)?(?:/video)?"
    r"[/_](?P<view>front|down|top|left_30|left_60|right_30|right_60)"
    r"[/_](?P<emotion>angry|contempt|disgusted|fear|happy|neutral|sad|surprised)"
    r"[/_]level_?(?P<level>[123])[/_](?P<number>\d{3})",
    re.ASCII,
)


def read(data: Path, folder: str, views: Collection[str], limits: Limits) -> tuple[list[dict], Bad]:
    """Each video of MEAD below <data>/<folder> as a clip, and the videos that are none.

    views: cameras to take. limits: of a video. Folders of sound are passed over.
    Returns rows with clip_id, source_id, subject_id, start_s, end_s, width, height, video, emotion,
    emotions (one, throughout), attributes (sex, intensity, view) and no actions.
    Raises BadFile if no video is named as MEAD's are, or none is of these views.
    """
    data = Path(data)
    films, bad = films_below(data, folder, "catalogue.mead.folder")
    films = [path for path in films if "audio" not in path.relative_to(data / folder).parts]
    labels = {path: _labels(path.relative_to(data / folder)) for path in films}
    if films and not any(labels.values()):
        raise unfit(films[0], len(films), EXPECTED, "catalogue.mead.folder")
    found = Counter(label["view"] for label in labels.values() if label)
    if found and not found.keys() & set(views):
        raise BadFile(
            data / folder,
            found=f"videos of the views {', '.join(sorted(found))} alone",
            expected=f"some of {', '.join(views)}",
            remedy="Set catalogue.mead.views to those that there are.",
        )
    for view in sorted(found.keys() - set(views)):
        log.info("view %s: %d videos passed over (catalogue.mead.views)", view, found[view])

    def facts(path: Path) -> dict:
        label = labels[path]
        if label is None:
            raise unfit(path, 1, EXPECTED, "catalogue.mead.folder")
        clip = film_facts(path, data, limits)
        return clip | {
            "subject_id": label["person"],
            "emotion": label["emotion"],
            "emotions": [over(label["emotion"], clip["end_s"])],
            "attributes": [
                "male" if label["person"].startswith("M") else "female",
                f"intensity:{label['level']}",
                f"view:{label['view']}",
            ],
        }

    taken = [path for path in films if labels[path] is None or labels[path]["view"] in views]
    named = (
        (_clip_id(path, labels[path], data / folder), path) for path in told(taken, "videos", log)
    )
    rows, unread = clips_of(named, facts)
    return rows, bad + unread


def _labels(path: Path) -> dict[str, str] | None:
    found = NAMED.fullmatch(path.with_suffix("").as_posix())
    return found.groupdict() if found else None


def _clip_id(path: Path, label: dict[str, str] | None, place: Path) -> str:
    if label is None:
        return path.relative_to(place).as_posix()
    return "{person}_{view}_{emotion}_level_{level}_{number}".format(**label)
