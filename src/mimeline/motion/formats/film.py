"""MP4: the face as it moves, and below it the timeline with a line where the film is."""

import json
import logging
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np

from mimeline.face.model import Face
from mimeline.face.motion import perform
from mimeline.face.render import Camera, draw
from mimeline.media.film import write_film
from mimeline.motion.about import about
from mimeline.motion.motion import Motion
from mimeline.progress import Pace
from mimeline.reporting.drawing import second_ticks
from mimeline.reporting.style import colours, readable_on
from mimeline.timeline.timeline import Interval, Timeline

log = logging.getLogger(__name__)

WIDTH, FACE = 720, 512  # pixels; the face's picture is square
LEFT, RIGHT = 92, 24  # of the tracks, from the picture's edges
ROW, BAR, TOP, BOTTOM = 28, 22, 14, 30
TRACK_NAMES = {"gaze_h": "gaze ↔", "gaze_v": "gaze ↕", "head_h": "head ↔", "head_v": "head ↕"}
GROUND, PANEL = (232, 234, 238), (250, 249, 246)
LANE, INK, SOFT, HEADING = (236, 233, 225), (34, 33, 30), (106, 102, 93), (166, 58, 36)
AT_ONCE = 64  # frames whose vertices are held
FONT = "sans"


def write(motion: Motion, path: Path, face: Face) -> None:
    """Write a film of the face, each frame of the motion a picture; frames that are not valid show
    a pale face.

    Without a timeline there is the face alone. The film's comment tells how each channel was had.
    """
    told = {key: value for key, value in about(motion).items() if key != "timeline"}
    comment = json.dumps(told, ensure_ascii=False, allow_nan=False)
    write_film(path, _pictures(motion, face), motion.fps, comment=comment)


def _pictures(motion: Motion, face: Face) -> Iterator[np.ndarray]:
    panel = None if motion.timeline is None else drawn(motion.timeline)
    width = FACE if panel is None else WIDTH
    camera, left = Camera.framing(face, FACE), (width - FACE) // 2
    valid = motion.frames["valid"].to_numpy(bool)
    pace = Pace(len(motion), "pictures", log)
    for start in range(0, len(motion), AT_ONCE):
        vertices = perform(face, motion.frames.iloc[start : start + AT_ONCE])
        for frame, own in enumerate(vertices, start):
            picture = np.full((FACE, width, 3), GROUND, np.uint8)
            picture[:, left : left + FACE] = draw(face, own, camera, GROUND)
            if not valid[frame]:
                picture = (picture // 3 + np.uint8(160)).astype(np.uint8)
            if panel is not None:
                picture = np.concatenate([picture, _at(panel, frame, motion.timeline)])
            yield picture
            pace.step()


def drawn(timeline: Timeline) -> np.ndarray:
    """The tracks of a timeline (H, WIDTH, 3), those that it measures, without where it is."""
    tracks = list(timeline.tracks)
    height = TOP + ROW * len(tracks) + BOTTOM
    panel = np.full((height + height % 2, WIDTH, 3), PANEL, np.uint8)
    for number, track in enumerate(tracks):
        top = TOP + ROW * number + (ROW - BAR) // 2
        name = TRACK_NAMES.get(track, track)
        _write(panel, name, LEFT - 12, top + BAR - 6, SOFT, 13, right=True)
        cv2.rectangle(panel, (LEFT, top), (WIDTH - RIGHT, top + BAR - 1), LANE, -1)
        for interval in timeline.tracks[track]:
            _bar(panel, interval, timeline, top)
    for second in second_ticks(0, timeline.seconds):
        x = _x(second * float(timeline.fps), timeline)
        bottom = TOP + ROW * len(tracks) + 4
        cv2.line(panel, (x, bottom), (x, bottom + 4), SOFT, 1)
        _write(panel, f"{second:g} s", x, bottom + 18, SOFT, 12, centre=True)
    return panel


def _bar(panel: np.ndarray, interval: Interval, timeline: Timeline, top: int) -> None:
    """An action; one of a half of the face takes half of the lane."""
    half = {"left": (0, 2), "right": (1, 2)}.get(interval.side, (0, 1))
    top += half[0] * BAR // 2
    bottom = top + BAR // half[1] - 1
    start, end = (_x(frame, timeline) for frame in (interval.start, interval.end))
    colour = colours()[interval.action][0]
    cv2.rectangle(panel, (start, top), (max(start, end - 2), bottom), _rgb(colour), -1)
    label = interval.action + (f" {interval.side}" if interval.side else "")
    size = 13 if half[1] == 1 else 10
    if _width(label, size) + 8 < end - start:
        _write(
            panel,
            label,
            start + 5,
            bottom - (6 if half[1] == 1 else 1),
            _rgb(readable_on(colour)),
            size,
        )


def _at(panel: np.ndarray, frame: int, timeline: Timeline) -> np.ndarray:
    panel = panel.copy()
    x = _x(frame + 0.5, timeline)
    cv2.line(panel, (x, TOP - 8), (x, len(panel) - BOTTOM + 2), HEADING, 2)
    return panel


def _x(frame: float, timeline: Timeline) -> int:
    span = WIDTH - LEFT - RIGHT
    return LEFT + round(span * frame / max(timeline.n_frames, 1))


def _write(picture, text, x, y, colour, size, right=False, centre=False) -> None:
    x -= _width(text, size) * (1 if right else 0.5 if centre else 0)
    cv2.putText(picture, text, (round(x), y), colour, cv2.FontFace(FONT), size, 400)


def _width(text: str, size: int) -> int:
    (_, _, width, _) = cv2.getTextSize((0, 0), text, (0, 0), cv2.FontFace(FONT), size, 400)
    return width


def _rgb(colour: str) -> tuple[int, int, int]:
    return tuple(int(colour[at : at + 2], 16) for at in (1, 3, 5))
