"""Frames of a film by their number."""

from collections.abc import Sequence
from pathlib import Path

import av
import numpy as np

from mimeline.errors import BadFile, unreadable

EXPECTED = "a film of constant rate, as cut and write_film make them"
REORDERED = 4  # frames between the order stored, which is sought in, and the order shown


def read_frames(path: Path, numbers: Sequence[int]) -> np.ndarray:
    """The frames with these numbers, in this order, each as often as it is named.

    path: a film of constant rate that this package wrote; for any other, `cut` makes one.
    Returns (len(numbers), H, W, 3) uint8 RGB.
    Raises BadFile if the film cannot be read or ends before one of the numbers.
    """
    wanted = sorted(set(numbers))
    if wanted and wanted[0] < 0:
        raise ValueError(f"frame {wanted[0]}: frames are numbered from 0")
    try:
        with av.open(f"file:{Path(path).absolute()}") as film:
            found, size = _pick(film, wanted)
    except (av.FFmpegError, OSError, IndexError) as error:
        remedy = "Make the film again."
        raise unreadable(path, error, expected=EXPECTED, remedy=remedy) from error
    if missing := [number for number in wanted if number not in found]:
        raise BadFile(
            path,
            found=f"no frame {missing[0]}",
            expected="a film that reaches it",
            remedy="Make the film again.",
        )
    if not wanted:
        return np.empty((0, *size, 3), np.uint8)
    return np.stack([found[number] for number in numbers])


def _pick(film, wanted: Sequence[int]) -> tuple[dict[int, np.ndarray], tuple[int, int]]:
    """number → picture, and the film's height and width. Enters at key frames, reads on."""
    video = film.streams.video[0]
    rate, found = video.average_rate, {}
    decoded, reached = film.decode(video), -1
    for number in wanted:
        if number - reached > rate:  # our key frames are about a second apart
            enter = max(0, number - REORDERED)
            film.seek(int(enter / rate / video.time_base), stream=video)
            decoded = film.decode(video)
        for frame in decoded:
            reached = round(frame.pts * frame.time_base * rate)
            if reached == number:
                found[number] = frame.to_ndarray(format="rgb24")
            if reached >= number:
                break
        else:
            break
    return found, (video.height, video.width)
