"""RealTalk's annotations: in each frame of a video, whose face is where and who speaks."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mimeline.clips.catalogues.json_records import GARBLED, pairs_of, read_object
from mimeline.errors import BadFile

EXPECTED = (
    'frames as {"0": {"people": {"p0": {"bbox": [left, top, right, bottom]}}, '
    '"current_speaker": "p0"}}'
)
BRIDGED = 5  # frames without a face that do not end a stretch: a detector misses some
SHORTEST = 25  # frames of a stretch: a second
JUMP = 0.5  # of a face's width: further in one frame goes a camera, not a head
MOST_WRONG = (
    0.01  # of the boxes, without a face in them; with more, their numbers mean another thing
)
OVERSHOOT = 0.1  # of the picture: detectors place faces partly beyond its edge


@dataclass(frozen=True)
class Box:
    """What all faces of a stretch lie in, in pixels; face: the usual width and height of one."""

    left: float
    top: float
    right: float
    bottom: float
    face: tuple[float, float]

    def grown(self, margin: float, width: int, height: int) -> tuple[float, float, float, float]:
        """left, top, right, bottom with margin times a face on each side, within the picture."""
        across, down = margin * self.face[0], margin * self.face[1]
        return (
            max(round(self.left - across), 0.0),
            max(round(self.top - down), 0.0),
            min(round(self.right + across), float(width)),
            min(round(self.bottom + down), float(height)),
        )


@dataclass(frozen=True)
class Faces:
    """The annotations of a video.

    frames: person → (n,) numbers of the frames with the person's face, rising. boxes: person →
    (n, 4) left, top, right, bottom in pixels. speaker: person → (m,) frames in which they speak.
    """

    frames: dict[str, np.ndarray]
    boxes: dict[str, np.ndarray]
    speaker: dict[str, np.ndarray]

    @property
    def n_frames(self) -> int:
        """One more than the last frame that anything is told of."""
        told = [*self.frames.values(), *self.speaker.values()]
        return max((int(frames[-1]) + 1 for frames in told if len(frames)), default=0)

    def until(self, n_frames: int) -> "Faces":
        """What is told of the first n_frames frames."""
        within = {person: frames < n_frames for person, frames in self.frames.items()}
        return Faces(
            frames={person: self.frames[person][keep] for person, keep in within.items()},
            boxes={person: self.boxes[person][keep] for person, keep in within.items()},
            speaker={person: found[found < n_frames] for person, found in self.speaker.items()},
        )

    def outside(self, width: int, height: int) -> bool:
        """Whether a face reaches far beyond a picture of this size: it is of a larger one."""
        corners = np.concatenate(list(self.boxes.values()))[:, 2:]  # (n, 2): right, bottom
        return bool((corners > np.array([width, height]) * (1 + OVERSHOOT)).any())

    def stretches(self, person: str) -> Iterator[tuple[int, int, Box]]:
        """First frame, end and box of each stretch with the person's face in one camera's picture.

        It ends where the face is away for more than BRIDGED frames or jumps; one of less than
        SHORTEST frames is none.
        """
        frames, boxes = self.frames[person], self.boxes[person]
        if not len(frames):
            return
        size = boxes[:, 2:] - boxes[:, :2]
        moved = np.abs(np.diff((boxes[:, :2] + boxes[:, 2:]) / 2, axis=0)).max(axis=1)
        ends = (np.diff(frames) > BRIDGED + 1) | (moved > JUMP * size[:-1, 0])
        for part in np.split(np.arange(len(frames)), np.flatnonzero(ends) + 1):
            first, end = int(frames[part[0]]), int(frames[part[-1]]) + 1
            if end - first >= SHORTEST:
                corners = *boxes[part, :2].min(axis=0), *boxes[part, 2:].max(axis=0)
                yield first, end, Box(*map(float, corners), tuple(np.median(size[part], axis=0)))

    def speaks(self, person: str, first: int, end: int) -> Iterator[tuple[int, int]]:
        """The half-open intervals of frames, within [first, end), in which the person speaks."""
        frames = self.speaker[person]
        frames = frames[(frames >= first) & (frames < end)]
        for run in np.split(frames, np.flatnonzero(np.diff(frames) > 1) + 1):
            if len(run):
                yield int(run[0]), int(run[-1]) + 1


def read_faces(path: Path, people: Sequence[str]) -> Faces:
    """The annotations of a video. Raises BadFile where it tells nobody's face."""
    content = read_object(path, EXPECTED)
    told: dict[str, dict[int, list[float]]] = {person: {} for person in people}
    speaker: dict[str, list[int]] = {person: [] for person in people}
    wrong: list[tuple[str, list[float]]] = []
    for key, entry in pairs_of(content):
        try:
            frame = _number(key)
            if entry is None:
                continue
            for person in people:
                face = (entry.get("people") or {}).get(person)
                if face and face.get("bbox") is not None:
                    box = _edges(face["bbox"])
                    if _is_box(box):
                        told[person][frame] = box
                    else:
                        wrong.append((key, box))
            if (speaking := entry.get("current_speaker")) in people:
                speaker[speaking].append(frame)
        except GARBLED as error:
            raise _unlike(path, str(error)[:200], f"frame {key[:20]}") from error
    n_boxes = len(wrong) + sum(map(len, told.values()))
    if not n_boxes:
        raise _unlike(path, "no frame with a face")
    if len(wrong) > MOST_WRONG * n_boxes:
        key, box = wrong[0]
        raise _unlike(path, f"{box}, {len(wrong)} of {n_boxes} boxes like it", f"frame {key}")
    frames = {person: np.array(sorted(boxes), int) for person, boxes in told.items()}
    return Faces(
        frames=frames,
        boxes={
            person: np.array([told[person][f] for f in frames[person]], float).reshape(-1, 4)
            for person in people
        },
        speaker={person: np.unique(np.array(found, int)) for person, found in speaker.items()},
    )


def _number(key: str) -> int:
    if not (key.isascii() and key.isdigit() and len(key) <= 9):
        raise ValueError(f"{key!r} where a frame's number belongs")
    return int(key)


def _edges(bbox: list[float]) -> list[float]:
    """left, top, right, bottom; what may follow, such as a score, is left out."""
    left, top, right, bottom = map(float, bbox[:4])
    return [left, top, right, bottom]


def _is_box(edges: list[float]) -> bool:
    left, top, right, bottom = edges
    return bool(np.isfinite(edges).all()) and left < right and top < bottom


def _unlike(path: Path, found: str, place: str = "") -> BadFile:
    return BadFile(
        path,
        place=place,
        found=found,
        expected=EXPECTED,
        remedy="Unpack the annotations again, or set catalogue.realtalk.annotations: null.",
    )
