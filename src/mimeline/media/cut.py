"""A piece of a video at a constant rate, frame by frame known where each comes from."""

import tempfile
from fractions import Fraction
from pathlib import Path

import numpy as np

from mimeline.atomic import whole
from mimeline.errors import BadFile
from mimeline.media import ffmpeg
from mimeline.media.box import Box
from mimeline.media.limits import Limits, Refused
from mimeline.media.probe import Probe

EARLY_US = 1000  # containers round times to a millisecond: what is due at the middle may be late
SEEK_BACK_S = 2.0  # seeking goes by the order stored, which runs ahead of the order shown
LEAST_SIDE = 16  # pixels: no face is seen in less, and encoders work in blocks of it
SOUND_BITS = 128_000
QUALITY = 18  # x264's constant rate factor: smaller is finer
PRESET = "veryfast"  # a third of the time of x264's own choice, and no larger files


def cut(
    source: Path,
    probe: Probe,
    target: Path,
    *,
    start_s: float,
    n_frames: int,
    fps: Fraction,
    box: Box | None,
    side_px: int | None,
    limits: Limits,
) -> np.ndarray:
    """Write n_frames of source at a constant rate as an MP4: H.264, and its sound as AAC.

    start_s: seconds after the first frame shown. fps: frames per second, exactly. box: the part of
    the picture, shrunk to what lies inside it; None: all. side_px: edge of a square that the part
    is scaled to fit, the rest of it black; None: as large as it is. A key frame comes every second.
    Output frame i shows the source frame of `frames_shown`.
    Returns (n_frames,) int64: the source frame that each shows, checked against what ffmpeg tells
    (not for AVI with H.264 or HEVC, which tells no times).
    Raises Refused if the source ends more than a frame too early (too_few_frames) or the part is
    too small (too_small), BadFile if a frame cannot be decoded.
    """
    expected = frames_shown(probe, source, start_s, n_frames, fps)
    part = (box or Box.whole(probe.width, probe.height)).within(probe.width, probe.height)
    _check_size(source, probe, *part[2:])
    options = {
        "c:v": "libx264",
        "crf": QUALITY,
        "preset": PRESET,
        "g": max(1, round(fps)),
        "c:a": "aac",
        "b:a": SOUND_BITS,
        "f": "mp4",
        "movflags": "+faststart",
        "stats_enc_pre_fmt:v": "{ptsi} {tbi}",
    }
    with whole(target) as film, tempfile.NamedTemporaryFile() as report:
        options["stats_enc_pre:v"] = ffmpeg.name_of(Path(report.name))
        # Where a file's index is poor, seeking lands too late: then it is read from its start.
        for seek_s in dict.fromkeys((_before(probe, expected[0]), None)):
            opened = _open(source, probe, seek_s, limits)
            streams = [_pictures(opened, probe, start_s, n_frames, fps, part, side_px)]
            if probe.has_sound:
                streams.append(_sound(opened, probe, start_s, float(n_frames / fps)))
            ffmpeg.write(streams, source, film, limits, **options)
            shown = _reported(Path(report.name).read_text(), probe, expected)
            if np.array_equal(probe.times[shown], probe.times[expected]):
                return expected
        lost = np.unique(expected[shown != expected]) if len(shown) == n_frames else expected[:0]
        raise BadFile(
            source,
            place=f"frame {lost[0]}" if len(lost) else "",
            found="a frame that cannot be decoded",
            expected="every frame of the piece",
            remedy="Take the video again, or leave the clip out.",
        )


def cut_sound(
    source: Path,
    probe: Probe,
    target: Path,
    *,
    start_s: float,
    length_s: float,
    rate: int = 16_000,
    limits: Limits,
) -> None:
    """Write a piece of the sound as a WAV: one channel, 16 bits, rate samples a second.

    start_s: seconds after the first picture shown. Silence fills what the source lacks.
    Raises BadFile if it has no sound or the sound cannot be decoded.
    """
    if not probe.has_sound:
        raise BadFile(
            source,
            found="a video without sound",
            expected="sound to cut",
            remedy="Leave the sound out.",
        )
    at = int(np.searchsorted(probe.times, probe.since_s + start_s, side="right")) - 1
    opened = _open(source, probe, _before(probe, at), limits)
    sound = _sound(opened, probe, start_s, length_s)
    options = {"c:a": "pcm_s16le", "ar": rate, "ac": 1, "f": "wav"}
    with whole(target) as made:
        ffmpeg.write([sound], source, made, limits, **options)


def frames_shown(
    probe: Probe, source: Path, start_s: float, n_frames: int, fps: Fraction
) -> np.ndarray:
    """(n_frames,) int64: the source frame that each frame of a cut shows.

    Frame i shows the last source frame that has begun a millisecond before the middle of
    [start_s + i / fps, start_s + (i + 1) / fps). This is what ffmpeg's fps filter does, and at
    equal rates it is the nearest frame.
    Raises Refused (too_few_frames) if the source ends more than a frame too early.
    """
    there = int((probe.duration_s - start_s) * fps + Fraction(1, 100))
    if there + 1 < n_frames:
        raise Refused(
            source,
            rule="too_few_frames",
            value=max(there, 0),
            limit=n_frames,
            unit="frames",
            found=f"an end at {round(probe.duration_s, 2):g} s",
            expected=f"the {round(float(start_s + n_frames / fps), 2):g} s that the clip asks for",
            remedy="Check the catalogue's times, and whether this is the video that they speak of.",
        )
    since_us = np.rint(probe.times * 1e6).astype(np.int64) - _start_us(probe, start_s) + EARLY_US
    second_us = 1_000_000 * fps.denominator
    due = (2 * since_us * fps.numerator + second_us) // (2 * second_us)  # rounded half up
    shown = np.searchsorted(due, np.arange(n_frames), side="right") - 1
    return np.maximum(shown, 0)


def _check_size(source: Path, probe: Probe, width: int, height: int) -> None:
    if min(width, height) < LEAST_SIDE:
        raise Refused(
            source,
            rule="too_small",
            value=min(width, height),
            limit=LEAST_SIDE,
            unit="px",
            found=f"{width} x {height} pixels to cut out of {probe.width} x {probe.height}",
            expected=f"at least {LEAST_SIDE} x {LEAST_SIDE}",
            remedy="Check the box, or leave the clip out.",
        )


def _start_us(probe: Probe, start_s: float) -> int:
    return round((probe.since_s + start_s) * 1e6)


def _before(probe: Probe, frame: int) -> float | None:
    """Where to enter the file to meet a frame; None: at its start."""
    seconds = float(probe.times[frame]) - SEEK_BACK_S
    return seconds if probe.ordered and seconds > probe.times[0] else None


def _open(source: Path, probe: Probe, seek_s: float | None, limits: Limits):
    """The input with the times that the file itself gives."""
    options = {"copyts": None, "noaccurate_seek": None}
    if seek_s is not None:
        options |= {"seek_timestamp": 1, "ss": f"{seek_s:.6f}"}
    return ffmpeg.open_input(source, limits, **options)


def _pictures(opened, probe: Probe, start_s: float, n_frames: int, fps: Fraction, part, side_px):
    left, top, width, height = part
    start = f"{_start_us(probe, start_s) - EARLY_US}"
    pictures = (
        opened[str(probe.stream)]
        .filter("settb", "AVTB")
        .filter("setpts", f"PTS-({start})" if probe.ordered else f"PTS-STARTPTS-({start})")
        .filter("fps", fps=str(fps), start_time=0)
        .filter("tpad", stop=-1, stop_mode="clone")
        .filter("trim", end_frame=n_frames)
    )
    if probe.pixel_shape != 1:
        pictures = pictures.filter("scale", probe.width, probe.height)
    pictures = pictures.filter("crop", width, height, left, top, exact=1)
    if side_px is not None:
        fit = {"force_original_aspect_ratio": "decrease", "force_divisible_by": 2}
        pictures = pictures.filter("scale", side_px, side_px, **fit).filter(
            "pad", side_px, side_px, -1, -1
        )
    return pictures.filter("setsar", 1).filter("format", "yuv420p")


def _sound(opened, probe: Probe, start_s: float, length_s: float):
    start = float(probe.since_s + start_s)
    return (
        opened[str(probe.sound_stream)]
        .filter("asetpts", f"PTS-({start:.6f})/TB")
        .filter("atrim", start=0, end=length_s)
        .filter("aresample", **{"async": 1, "first_pts": 0})
        .filter("apad", whole_dur=length_s)
        .filter("atrim", end=length_s)
    )


def _reported(report: str, probe: Probe, expected: np.ndarray) -> np.ndarray:
    """The source frames that ffmpeg says it shows; what is expected where it cannot tell."""
    words = report.split()
    ticks = np.array(words[::2], dtype=np.int64)
    if len(ticks) != len(expected):
        return np.empty(0, np.int64)
    tick = Fraction(words[1])
    seconds = ticks * (tick.numerator / tick.denominator)
    shown = np.searchsorted(probe.times, seconds - 1e-6)
    unknown = not probe.ordered or ticks == np.iinfo(np.int64).min
    return np.where(unknown, expected, np.minimum(shown, probe.n_frames - 1))
