"""RAVDESS as a catalogue: what is shown stands in each file's name, as seven numbers.

Livingstone and Russo 2018, The Ryerson Audio-Visual Database of Emotional Speech and Song.
"""

import logging
import re
from pathlib import Path

from mimeline.clips.catalogues.films import film_facts, films_below, unfit
from mimeline.clips.catalogues.folder import Bad, clips_of
from mimeline.clips.intervals import over
from mimeline.media.limits import Limits
from mimeline.progress import told

log = logging.getLogger(__name__)

EXPECTED = (
    "01-01-06-01-02-01-12: modality, channel, emotion, intensity, statement, repetition and actor"
)
NAMED = re.compile(
    r"(?P<modality>0[1-3])-(?P<channel>0[12])-(?P<emotion>0[1-8])-(?P<intensity>0[12])"
    r"-(?P<statement>0[12])-(?P<repetition>0[12])-(?P<actor>0[1-9]|1\d|2[0-4])",
    re.ASCII,
)
WITH_SOUND, SILENT, SOUND_ALONE = "01", "02", "03"
CHANNELS = {"01": "speech", "02": "song"}
EMOTIONS = {
    "01": "neutral",
    "02": "calm",
    "03": "happy",
    "04": "sad",
    "05": "angry",
    "06": "fearful",
    "07": "disgust",
    "08": "surprised",
}
INTENSITIES = {"01": "normal", "02": "strong"}
STATEMENTS = {"01": "kids", "02": "dogs"}


def read(data: Path, folder: str, limits: Limits) -> tuple[list[dict], Bad]:
    """Each performance of RAVDESS below <data>/<folder> as a clip, and the videos that are none.

    limits: of a video. A performance that is there with sound and without is taken with it: the
    pictures are the same. Sound alone is passed over.
    Returns rows with clip_id, source_id, subject_id, start_s, end_s, width, height, video, emotion,
    emotions (one, throughout), attributes and no actions. Raises BadFile if no video is named so.
    """
    data = Path(data)
    films, bad = films_below(data, folder, "catalogue.ravdess.folder")
    labels = {path: NAMED.fullmatch(path.stem) for path in films}
    if films and not any(labels.values()):
        raise unfit(films[0], len(films), EXPECTED, "catalogue.ravdess.folder")
    modality = {path: label["modality"] for path, label in labels.items() if label}
    with_sound = {_performance(path) for path in modality if modality[path] == WITH_SOUND}
    heard = [path for path in modality if modality[path] == SOUND_ALONE]
    twice = [
        path for path in modality if modality[path] == SILENT and _performance(path) in with_sound
    ]
    if heard:
        log.info("%d files of sound alone (03-...) passed over", len(heard))
    if twice:
        log.info("%d videos without sound (02-...) passed over: 01-... shows the same", len(twice))

    def facts(path: Path) -> dict:
        label = labels[path]
        if label is None:
            raise unfit(path, 1, EXPECTED, "catalogue.ravdess.folder")
        clip = film_facts(path, data, limits)
        emotion = EMOTIONS[label["emotion"]]
        return clip | {
            "subject_id": f"Actor_{label['actor']}",
            "emotion": emotion,
            "emotions": [over(emotion, clip["end_s"])],
            "attributes": [
                "male" if int(label["actor"]) % 2 else "female",
                f"intensity:{INTENSITIES[label['intensity']]}",
                f"statement:{STATEMENTS[label['statement']]}",
                f"channel:{CHANNELS[label['channel']]}",
                f"repetition:{int(label['repetition'])}",
            ],
        }

    passed = {*heard, *twice}
    taken = [path for path in films if path not in passed]
    rows, unread = clips_of(((path.stem, path) for path in told(taken, "videos", log)), facts)
    return rows, bad + unread


def _performance(path: Path) -> str:
    """What tells a performance from every other: all but the modality."""
    return path.stem.partition("-")[2]
