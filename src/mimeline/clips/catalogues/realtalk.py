"""RealTalk as a catalogue: videos of two people, each of them a clip or several.

Geng et al. 2023, Affective Faces for Goal-Driven Dyadic Communication. p0 is the person on the
picture's left, p1 the one on its right; frames count from 0.
"""

import logging
from collections.abc import Iterator
from pathlib import Path

from mimeline.clips.catalogues.faces import Faces, read_faces
from mimeline.clips.catalogues.films import films_below, one_of_a_name
from mimeline.clips.catalogues.folder import Bad, folder_in
from mimeline.errors import BadFile, MimelineError
from mimeline.media.limits import Limits
from mimeline.media.probe import Probe, probe
from mimeline.progress import told

log = logging.getLogger(__name__)

FPS = 25
SLACK = 5  # frames that readers of one AVI may disagree by at its end
HALF = ("half_picture", {"detail": "no annotations: the face is somewhere in this half"})
PEOPLE = ("p0", "p1")  # from the picture's left to its right


def read(
    data: Path, folder: str, annotations: str | None, margin: float, limits: Limits
) -> tuple[list[dict], Bad]:
    """The two people of each video below <data>/<folder> as clips, and what cannot be read.

    annotations: the folder with <video>.json, which tell in every frame whose face is where and who
    speaks; None: there is none. margin: how far a box reaches beyond the faces in it, as a share
    of a face. limits: of a video.
    Where a video's annotations are there, a clip <video>_p0_<first frame> is a stretch in which the
    person's face is found without a break, its box holds all these faces, and it has an action
    `talk` wherever the person speaks. Where they are not, <video>_p0 is the whole video and its box
    half of the picture.
    Returns rows with clip_id, source_id (the video), subject_id (<video>_p0), start_s, end_s,
    width and height of the box in pixels, bbox_*, actions and video; of a half, a note for the
    ledger.
    Raises BadFile if there is no video at all.
    """
    data = Path(data)
    films, bad = films_below(data, folder, "catalogue.realtalk.folder")
    told_of = _annotation_files(data, annotations)
    films, rows, halves = one_of_a_name(films), [], 0
    for path in told(films, "videos", log):
        ids = [f"{path.stem}_{person}" for person in PEOPLE]
        try:
            film = probe(path, limits)
            faces = _faces(told_of, path, film)
        except MimelineError as error:
            bad += [(clip_id, error) for clip_id in ids]
            continue
        halves += faces is None
        for number, (person, clip_id) in enumerate(zip(PEOPLE, ids, strict=True)):
            video = path.relative_to(data).as_posix()
            about = {"source_id": path.stem, "subject_id": clip_id, "video": video}
            if faces is None:
                rows.append({"clip_id": clip_id} | about | _half(film, number))
            else:
                rows += [row | about for row in _stretches(clip_id, faces, person, film, margin)]
    if halves:
        log.warning(
            "%d of %d videos have no annotations: each person is half of the picture, throughout",
            halves,
            len(films),
        )
    return rows, bad


def _annotation_files(data: Path, annotations: str | None) -> Path | None:
    if annotations is None or not (data / annotations).is_dir():
        return None
    return folder_in(data, annotations, "catalogue.realtalk.annotations")


def _faces(folder: Path | None, video: Path, film: Probe) -> Faces | None:
    """The annotations of a video, None where there are none. Raises BadFile."""
    if folder is None or not (path := folder / f"{video.stem}.json").is_file():
        return None
    if abs(film.rate - FPS) > 0.01 * FPS:
        raise BadFile(
            video,
            found=f"{float(film.rate):.5g} frames per second",
            expected=f"{FPS}, as the frames of {path.name} are numbered",
            remedy="Take the published AVI, or set catalogue.realtalk.annotations: null.",
        )
    faces = read_faces(path, PEOPLE)
    if faces.n_frames > film.n_frames + SLACK:
        raise BadFile(
            path,
            found=f"annotations up to frame {faces.n_frames - 1}",
            expected=f"frames of the video, 0 to {film.n_frames - 1}",
            remedy="Take the video that they were made from, at its own 25 frames per second.",
        )
    if faces.outside(film.width, film.height):
        raise BadFile(
            path,
            found="faces outside of the picture",
            expected=f"boxes in pixels of {film.width} x {film.height}",
            remedy="Take the video that they were made from, in its own size.",
        )
    return faces.until(film.n_frames)


def _half(film: Probe, number: int) -> dict:
    """The whole video, and the half of the picture that a person is said to be in."""
    middle = film.width / 2
    box = (number * middle, 0.0, (number + 1) * middle, film.height)
    return _clip(film, 0, film.n_frames, box) | {"notes": [HALF]}


def _stretches(
    clip_id: str, faces: Faces, person: str, film: Probe, margin: float
) -> Iterator[dict]:
    for first, end, box in faces.stretches(person):
        clip = _clip(film, first, end, box.grown(margin, film.width, film.height))
        talk = [
            {"name": "talk", **_seconds(film, first, a, b), "uncertainty_s": None}
            for a, b in faces.speaks(person, first, end)
        ]
        yield {"clip_id": f"{clip_id}_{first:06d}"} | clip | {"actions": talk}


def _clip(film: Probe, first: int, end: int, box: tuple[float, float, float, float]) -> dict:
    left, top, right, bottom = box
    return {
        **_seconds(film, 0, first, end),
        "width": round(right - left),
        "height": round(bottom - top),
        "bbox_top": float(top),
        "bbox_bottom": float(bottom),
        "bbox_left": float(left),
        "bbox_right": float(right),
        "actions": [],
    }


def _seconds(film: Probe, origin: int, first: int, end: int) -> dict[str, float]:
    """Frames [first, end) as seconds after the frame origin."""
    start_s, end_s = film.times[[first, end - 1]] - film.times[origin]
    return {"start_s": round(float(start_s), 6), "end_s": round(float(end_s + film.frame_s), 6)}
