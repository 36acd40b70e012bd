"""What a film looks like, in a few bits a second that survive scaling and coding.

A picture's bits are the signs of the lowest frequencies of its cosine transform, as in perceptual
hashes; measured on copies and on strangers by benchmarks/near_duplicates.py.
"""

from pathlib import Path

import av
import cv2
import numpy as np

from mimeline.errors import BadFile, unreadable

BITS = 64
SIDE = 32  # pixels: what is finer than that does not survive coding
LEAST_CONTRAST = 4.0  # grey levels of 256, standard deviation: below it a picture is flat
LEAST_GAP_S = 0.5  # encoders add key frames of their own where the picture changes


def _lowest_frequencies() -> tuple[np.ndarray, np.ndarray]:
    """Rows and columns (64,) each of the cosine transform, from low to high, without the mean."""
    row, column = np.divmod(np.arange(SIDE * SIDE), SIDE)
    lowest = np.lexsort((column, row, row**2 + column**2))[1 : BITS + 1]
    return row[lowest], column[lowest]


ROWS, COLUMNS = _lowest_frequencies()
# A mirrored picture's odd frequencies across change their sign: bits ^ MIRRORED.
MIRRORED = np.packbits(COLUMNS % 2 == 1, bitorder="little").view("<i8")[0]


def fingerprint(film: Path) -> tuple[np.ndarray, np.ndarray]:
    """Frames looked at, (m,) int64, and the bits of each, (m,) int64.

    film: a film of constant rate with a key frame every second, as `cut` makes it: its key frames
    are looked at, and nothing else is decoded. Flat pictures, which would be like any other, are
    left out.
    Raises BadFile if the film cannot be read.
    """
    expected, remedy = "a film of constant rate", "Make the film again."
    frames, bits = [], []
    try:
        with av.open(f"file:{Path(film).absolute()}") as file:
            if not file.streams.video or not file.streams.video[0].average_rate:
                raise BadFile(film, found="no film", expected=expected, remedy=remedy)
            video = file.streams.video[0]
            video.codec_context.skip_frame = "NONKEY"
            video.codec_context.thread_count = 1
            rate = video.average_rate
            for frame in file.decode(video):
                number = round((frame.pts or 0) * frame.time_base * rate)
                if frames and number - frames[-1] < LEAST_GAP_S * rate:
                    continue
                if (told := bits_of(_grey(frame))) is not None:
                    frames.append(number)
                    bits.append(told)
    except (av.FFmpegError, OSError) as error:
        raise unreadable(film, error, expected=expected, remedy=remedy) from error
    return np.array(frames, np.int64), np.array(bits, np.int64)


def _grey(frame: av.VideoFrame) -> np.ndarray:
    """A frame's brightness, (H, W) uint8, as it is stored."""
    plane = frame.reformat(format="yuv420p").planes[0]
    rows = np.frombuffer(plane, np.uint8).reshape(plane.height, plane.line_size)
    return rows[:, : plane.width]


def bits_of(grey: np.ndarray) -> np.int64 | None:
    """The bits of a picture (H, W) uint8; None where it is flat."""
    small = cv2.resize(grey, (SIDE, SIDE), interpolation=cv2.INTER_AREA).astype(np.float32)
    if small.std() < LEAST_CONTRAST:
        return None
    signs = cv2.dct(small)[ROWS, COLUMNS] > 0  # (64,)
    return np.packbits(signs, bitorder="little").view("<i8")[0]
