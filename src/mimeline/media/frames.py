"""Frames of a film by their number."""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import av
import numpy as np

from mimeline.errors import BadFile, unreadable

EXPECTED = "a film of constant rate, as cut and write_film make them"
REMEDY = "Make the film again."
REORDERED = 4  # frames between the order stored, which is sought in, and the order shown


def read_frames(path: Path, numbers: Iterable[int]) -> Iterator[tuple[int, np.ndarray]]:
    """The frames with these numbers, one at a time as (number, picture): each once, in order.

    path: a film of constant rate that this package wrote; for any other, `cut` makes one.
    A picture is (H, W, 3) uint8 RGB.
    Raises, on the way, BadFile if the film cannot be read or ends before one of the numbers.
    """
    wanted = sorted(set(numbers))
    if wanted and wanted[0] < 0:
        raise ValueError(f"frame {wanted[0]}: frames are numbered from 0")
    try:
        with av.open(f"file:{Path(path).absolute()}") as film:
            if not film.streams.video or not film.streams.video[0].average_rate:
                raise BadFile(path, found="no film", expected=EXPECTED, remedy=REMEDY)
            yield from _pick(path, film, wanted)
    except (av.FFmpegError, OSError) as error:
        raise unreadable(path, error, expected=EXPECTED, remedy=REMEDY) from error


def _pick(path: Path, film, wanted: Sequence[int]) -> Iterator[tuple[int, np.ndarray]]:
    """Enters at key frames, reads on from there."""
    video = film.streams.video[0]
    rate = video.average_rate
    decoded, reached = film.decode(video), -1
    for number in wanted:
        if number - reached > rate:  # our key frames are about a second apart
            enter = max(0, number - REORDERED)
            film.seek(int(enter / rate / video.time_base), stream=video)
            decoded = film.decode(video)
        for frame in decoded:
            reached = round((frame.pts or 0) * frame.time_base * rate)
            if reached >= number:
                break
        if reached != number:
            expected = "a film that reaches it"
            raise BadFile(path, found=f"no frame {number}", expected=expected, remedy=REMEDY)
        yield number, frame.to_ndarray(format="rgb24")
