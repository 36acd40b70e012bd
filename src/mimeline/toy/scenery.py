"""What else a camera sees: an empty room, a sheet of paper before a face."""

import numpy as np
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from mimeline.toy.appearance import Colour

RISE = 6  # frames in which the paper comes up or goes down
PAPER, INK = (244, 244, 240), (120, 126, 138)
SHEET = (0.16, 0.84, 0.10)  # left, right and top of the raised sheet, shares of the picture
LINES = np.arange(0.24, 0.9, 0.075)  # tops of the lines of writing
# All of it is cool in colour, so that nothing in a room without a face looks like skin.
WALL, WHITE, FLOOR, CHAIR = (200, 212, 220), (238, 240, 240), (112, 122, 130), (52, 72, 84)
SEA, SKY = (84, 132, 150), (176, 206, 222)


def room(size: int) -> np.ndarray:
    """An empty room (size, size, 3) uint8: a picture on the wall, a chair that nobody sits on."""
    canvas = np.full((size, size, 3), WALL, float)
    for left, right, top, bottom, colour in (
        (0.0, 1.0, 0.80, 1.0, FLOOR),
        (0.0, 1.0, 0.77, 0.80, WHITE),
        (0.56, 0.92, 0.10, 0.38, WHITE),
        (0.59, 0.89, 0.13, 0.26, SKY),
        (0.59, 0.89, 0.26, 0.35, SEA),
        (0.28, 0.32, 0.44, 0.98, CHAIR),  # the chair's back, rails, seat and legs
        (0.54, 0.58, 0.44, 0.98, CHAIR),
        (0.28, 0.58, 0.46, 0.51, CHAIR),
        (0.28, 0.58, 0.56, 0.61, CHAIR),
        (0.25, 0.61, 0.74, 0.79, CHAIR),
    ):
        _fill(canvas, left, right, top, bottom, colour)
    return canvas.round().astype(np.uint8)


def raised(covered: np.ndarray) -> np.ndarray:
    """How far the paper is up, (n,) in [0, 1]: fully where covered (n,), moving just outside."""
    near = maximum_filter1d(covered.astype(float), 2 * (RISE // 2) + 1)
    return np.where(covered, 1.0, uniform_filter1d(near, RISE + 1))


def behind_paper(picture: np.ndarray, up: float) -> np.ndarray:
    """The picture (size, size, 3) with a written sheet held before it, up in [0, 1]."""
    if up == 0:
        return picture
    left, right, top = SHEET
    top = 1 - up * (1 - top)
    canvas = picture.astype(float)
    _fill(canvas, left, right, top, 1, PAPER)
    for number, line in enumerate(LINES - SHEET[2]):
        end = right - (0.08 if number % 3 else 0.22)
        _fill(canvas, left + 0.08, end, top + line, top + line + 0.022, INK)
    return canvas.round().astype(np.uint8)


def _fill(canvas: np.ndarray, left, right, top, bottom, colour: Colour) -> None:
    """Paint a rectangle given in shares of the picture; its edges blend into their pixels."""
    columns, rows = _cover(left, right, len(canvas)), _cover(top, bottom, len(canvas))
    box = np.ix_(rows > 0, columns > 0)
    share = np.outer(rows, columns)[box][..., None]  # (height, width, 1)
    canvas[box] += share * (np.array(colour) - canvas[box])


def _cover(first: float, last: float, size: int) -> np.ndarray:
    """How much of each of size pixels, (size,) in [0, 1], lies between two shares of the edge."""
    pixel = np.arange(size)
    return (np.minimum(last * size, pixel + 1) - np.maximum(first * size, pixel)).clip(0, 1)
