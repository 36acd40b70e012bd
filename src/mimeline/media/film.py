"""Pictures, and the sound that goes with them, as an MP4 that every browser plays."""

from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from itertools import chain, pairwise
from pathlib import Path

import av
import numpy as np
from av.codec.context import Flags

from mimeline.atomic import whole

TICKS_PER_S = 90_000  # of a film with times of its own
# A smaller constant rate factor is finer. Of small pictures, x264's macroblock tree depends on
# memory that nobody wrote: without it the same pictures give the same bytes.
ENCODING = {"crf": "20", "preset": "veryfast", "x264-params": "mbtree=0"}


def write_film(
    path: Path,
    pictures: Iterable[np.ndarray],
    fps: Fraction,
    sound: np.ndarray | None = None,
    sound_rate: int = 16_000,
    times: Sequence[float] | None = None,
    comment: str = "",
) -> None:
    """Write an H.264 film with AAC sound; the same pictures give the same bytes.

    pictures: (H, W, 3) uint8 RGB each, all of one even size; taken one by one. fps: frames per
    second; a key frame comes about every second. sound: (n,) in [-1, 1], sound_rate per second,
    starting with the first picture. times: when each picture is shown, rising seconds, for a film
    of variable rate. comment: for players and people to read.
    Raises ValueError for no picture, a size that is odd or changes, or times that do not fit.
    """
    fps = Fraction(fps)
    pictures = iter(pictures)
    first = next(pictures, None)
    if first is None:
        raise ValueError("a film needs a picture")
    if first.shape[0] % 2 or first.shape[1] % 2:
        raise ValueError(f"pictures of even size are needed, not {first.shape[:2]}")
    if times is not None and not all(a < b for a, b in pairwise(times)):
        raise ValueError("times must rise")
    options = {"movflags": "+faststart", "fflags": "+bitexact"}
    with (
        whole(path) as temporary,
        av.open(f"file:{temporary.absolute()}", "w", format="mp4", options=options) as film,
    ):
        if comment:
            film.metadata["comment"] = comment
        streams = [_video_stream(film, first, fps, times)]
        frames = _frames(chain([first], pictures), streams[0].time_base, fps, times)
        if sound is not None:
            streams.append(_sound_stream(film, sound_rate))
            frames = _with_sound(frames, np.asarray(sound, np.float32), sound_rate)
        for frame in frames:
            stream = streams[isinstance(frame, av.AudioFrame)]
            film.mux(stream.encode(frame))
        for stream in streams:
            film.mux(stream.encode(None))


def _video_stream(film, first: np.ndarray, fps: Fraction, times: Sequence[float] | None):
    video = film.add_stream("libx264", rate=fps, options=ENCODING)
    video.height, video.width = first.shape[:2]
    video.pix_fmt = "yuv420p"
    video.time_base = 1 / fps if times is None else Fraction(1, TICKS_PER_S)
    codec = video.codec_context
    codec.time_base = video.time_base
    codec.thread_count = 1
    codec.gop_size = max(1, round(fps))
    codec.flags |= Flags.bitexact
    return video


def _sound_stream(film, sound_rate: int):
    audio = film.add_stream("aac", rate=sound_rate, layout="mono")
    audio.codec_context.flags |= Flags.bitexact
    return audio


def _frames(
    pictures: Iterable[np.ndarray],
    time_base: Fraction,
    fps: Fraction,
    times: Sequence[float] | None,
) -> Iterator[av.VideoFrame]:
    shape, number = None, -1
    for number, picture in enumerate(pictures):
        if picture.shape != (shape := shape or picture.shape) or picture.dtype != np.uint8:
            raise ValueError(f"picture {number} is {picture.shape} {picture.dtype}, not {shape}")
        if times is not None and number >= len(times):
            raise ValueError(f"{len(times)} times for more pictures")
        frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24")
        seconds = number / fps if times is None else Fraction(float(times[number]))
        frame.pts, frame.time_base = round(seconds / time_base), time_base
        yield frame
    if times is not None and number + 1 != len(times):
        raise ValueError(f"{len(times)} times for {number + 1} pictures")


def _with_sound(
    frames: Iterator[av.VideoFrame], sound: np.ndarray, rate: int
) -> Iterator[av.VideoFrame | av.AudioFrame]:
    """Between the pictures the sound up to each; after the last, what remains."""
    done = 0
    for frame in frames:
        until = min(len(sound), int(frame.pts * frame.time_base * rate))
        if until > done:
            yield _samples(sound[done:until], done, rate)
            done = until
        yield frame
    if done < len(sound):
        yield _samples(sound[done:], done, rate)


def _samples(sound: np.ndarray, start: int, rate: int) -> av.AudioFrame:
    samples = np.clip(sound, -1.0, 1.0)[None]
    frame = av.AudioFrame.from_ndarray(samples, format="fltp", layout="mono")
    frame.sample_rate, frame.pts, frame.time_base = rate, start, Fraction(1, rate)
    return frame
