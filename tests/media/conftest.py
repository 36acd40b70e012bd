"""Videos whose frames carry their number as a pattern of blocks, and how to read it off."""

from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest

from mimeline.media.limits import Limits

BITS, BLOCK = 12, 16  # 4 x 3 blocks of 16 pixels


def numbered(number: int) -> np.ndarray:
    """(48, 64, 3) uint8: the number in blocks, black and white."""
    bits = (number >> np.arange(BITS)) & 1
    blocks = np.where(bits.reshape(3, 4), 235, 20).astype(np.uint8)
    return np.repeat(np.kron(blocks, np.ones((BLOCK, BLOCK), np.uint8))[..., None], 3, axis=2)


def number_on(picture: np.ndarray) -> int:
    height, width = picture.shape[:2]
    rows, columns = (np.arange(3) + 0.5) * height / 3, (np.arange(4) + 0.5) * width / 4
    bits = picture[np.ix_(rows.astype(int), columns.astype(int))].mean(axis=2).ravel() > 127
    return int((bits << np.arange(BITS)).sum())


@pytest.fixture(scope="session")
def limits() -> Limits:
    return Limits(timeout_s=30.0)


@pytest.fixture(scope="session")
def picture_of():
    """The picture of a number."""
    return numbered


@pytest.fixture(scope="session")
def number_of():
    """The number on a picture."""
    return number_on


@pytest.fixture(scope="session")
def make_video():
    """Writes a numbered video; its frames are shown at the given seconds."""

    def make_video(
        path: Path,
        times,
        *,
        codec: str = "libx264",
        rate: Fraction = Fraction(30),
        tick: Fraction = Fraction(1, 90_000),
        options: dict | None = None,
        rotation: int = 0,
        pixel_shape: Fraction = Fraction(1),
        picture=numbered,
        sound: np.ndarray | None = None,
        title: str = "",
    ) -> Path:
        with av.open(str(path), "w") as file:
            file.metadata["title"] = title
            video = file.add_stream(codec, rate=rate, options=options or {})
            video.height, video.width = picture(0).shape[:2]
            video.pix_fmt = "yuvj420p" if codec == "mjpeg" else "yuv420p"
            video.codec_context.sample_aspect_ratio = pixel_shape
            video.time_base = video.codec_context.time_base = tick
            video.codec_context.gop_size = 20
            if rotation:
                video.set_display_rotation(rotation)
            if sound is not None:
                audio = file.add_stream("aac", rate=16_000, layout="mono")
                frame = av.AudioFrame.from_ndarray(
                    sound[None].astype(np.float32), format="fltp", layout="mono"
                )
                frame.sample_rate, frame.pts, frame.time_base = 16_000, 0, Fraction(1, 16_000)
                file.start_encoding()
                packets = [*audio.encode(frame), *audio.encode(None)]
            for number, seconds in enumerate(times):
                shown = av.VideoFrame.from_ndarray(picture(number), format="rgb24")
                shown.pts, shown.time_base = round(Fraction(seconds) / tick), tick
                file.mux(video.encode(shown))
            file.mux(video.encode(None))
            if sound is not None:
                file.mux(packets)
        return path

    return make_video


@pytest.fixture(scope="session")
def numbers_in():
    """The numbers on a file's frames, in the order shown."""

    def numbers_in(path: Path) -> list[int]:
        with av.open(str(path)) as file:
            frames = sorted(file.decode(video=0), key=lambda frame: frame.pts)
            return [number_on(frame.to_ndarray(format="rgb24")) for frame in frames]

    return numbers_in
