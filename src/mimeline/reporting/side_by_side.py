"""A film of made motion beside the real, with the timeline that was asked for running along."""

import base64
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np
import pandas as pd

from mimeline.media.film import write_film
from mimeline.reporting import words
from mimeline.reporting.album import SIZE, data_uri, square
from mimeline.reporting.stand_in import StandIn
from mimeline.reporting.style import themes

# Pixels: edge of a face, space between the two, height of the line above them, margin, and the
# room below that a player covers with its controls.
FACE, GAP, HEAD, PAD, FOOT = 192, 8, 22, 10, 56
# The timeline to their right: its width, that of an action's name, height of a track and its bar.
TIME, NAME, ROW, BAR = 336, 94, 24, 11
LEFT = PAD + 2 * FACE + GAP + 24  # of the timeline
LETTERS = cv2.FontFace("sans")
SMALL, WEIGHT = 12, 400
DARK = themes()["dark"]  # a film is dark on either page


@dataclass(frozen=True)
class SideBySide:
    """film, poster: data URIs. strips: "made" and "real" → data URIs, None where not measured."""

    film: str
    poster: str
    width: int
    height: int
    strips: dict[str, list[str | None]]


def side_by_side(
    stand_in: StandIn,
    made: pd.DataFrame,
    real: pd.DataFrame,
    runs: Sequence[Sequence[tuple[str, int, int]]],
    end: int,
    fps: Fraction,
    chosen: Sequence[int],
) -> SideBySide:
    """Draw frames [0, end) of both.

    made, real: the clip's `motion`. runs: per track (action, first frame, end frame).
    chosen: the frames of the strips.
    """
    stage = _stage([own for own in runs if own], end)
    busiest = _busiest(runs, end)
    kept: dict[str, dict[int, np.ndarray]] = {"made": {}, "real": {}}
    poster: list[np.ndarray] = []

    def frames() -> Iterator[np.ndarray]:
        both = zip(_faces(stand_in, made, end), _faces(stand_in, real, end), strict=True)
        for number, pair in enumerate(both):
            for name, face in zip(kept, pair, strict=True):
                if number in chosen and face is not None:
                    kept[name][number] = face
            picture = _compose(stage, pair, runs, number, end)
            if number == busiest:
                poster.append(picture)
            yield picture

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "film.mp4"
        write_film(path, frames(), fps)
        film = "data:video/mp4;base64," + base64.b64encode(path.read_bytes()).decode()
    height, width = stage.shape[:2]
    strips = {name: [_small(own.get(number)) for number in chosen] for name, own in kept.items()}
    return SideBySide(film, data_uri(poster[0]), width, height, strips)


def _busiest(runs: Sequence[Sequence[tuple[str, int, int]]], end: int) -> int:
    """The frame in which most actions are asked for."""
    active = np.zeros(end, int)
    for own in runs:
        for _, first, stop in own:
            active[first:stop] += 1
    best = np.flatnonzero(active == active.max())
    return int(best[len(best) // 2])


def _faces(stand_in: StandIn, motion: pd.DataFrame, end: int) -> Iterator[np.ndarray | None]:
    """A picture per frame of [0, end); None where the motion was not measured."""
    known = motion[motion["valid"] & motion["frame"].between(0, end - 1)].sort_values("frame")
    pictures = stand_in.pictures(known, FACE, ground=_rgb("--raised"))
    present = set(known["frame"])
    for number in range(end):
        yield next(pictures) if number in present else None


def _stage(runs: Sequence[Sequence[tuple[str, int, int]]], end: int) -> np.ndarray:
    """What does not move: the words above the faces and the bars of the timeline."""
    stage = np.full((HEAD + FACE + FOOT, LEFT + TIME + NAME, 3), _rgb("--paper"), np.uint8)
    for place, text in enumerate(("made", "real, drawn")):
        _write(stage, text, PAD + place * (FACE + GAP) + 1, HEAD - 7, _rgb("--soft"))
    for place, own in enumerate(runs):
        top = _top(place, len(runs))
        stage[top + BAR // 2, LEFT : LEFT + TIME] = _rgb("--rule")
        for action, first, stop in own:
            a, b = _column(first, end), _column(min(stop, end), end)
            stage[top : top + BAR, a : max(b, a + 1)] = _rgb(f"--{action}")
    return stage


def _compose(
    stage: np.ndarray,
    faces: Sequence[np.ndarray | None],
    runs: Sequence[Sequence[tuple[str, int, int]]],
    number: int,
    end: int,
) -> np.ndarray:
    picture = stage.copy()
    for place, face in enumerate(faces):
        left = PAD + place * (FACE + GAP)
        area = picture[HEAD : HEAD + FACE, left : left + FACE]
        area[:] = _rgb("--raised") if face is None else face
    shown = [own for own in runs if own]
    at = _column(number + 0.5, end)
    picture[HEAD : HEAD + FACE, at] = _rgb("--ink")
    for place, own in enumerate(shown):
        for action, first, stop in own:
            if first <= number < stop:
                y = _top(place, len(shown)) + BAR - 1
                _write(picture, words.spaced(action), LEFT + TIME + PAD, y, _rgb("--ink"))
    return picture


def _top(place: int, tracks: int) -> int:
    """Upper edge of a track's bar; the tracks stand in the middle of the faces' height."""
    return HEAD + (FACE - ROW * tracks) // 2 + ROW * place + (ROW - BAR) // 2


def _column(frame: float, end: int) -> int:
    """Where a frame stands in the timeline."""
    return LEFT + int(frame / end * TIME)


def _write(picture: np.ndarray, text: str, x: int, y: int, colour: tuple[int, int, int]) -> None:
    cv2.putText(picture, text, (x, y), colour, LETTERS, SMALL, WEIGHT)


def _small(face: np.ndarray | None) -> str | None:
    return None if face is None else data_uri(square(face, SIZE))


def _rgb(name: str) -> tuple[int, int, int]:
    value = DARK[name].lstrip("#")
    return tuple(int(value[at : at + 2], 16) for at in (0, 2, 4))
