"""The one place that starts ffmpeg: never through a shell, never on a format we did not name."""

import signal
from collections.abc import Sequence
from pathlib import Path

import ffmpeg
import imageio_ffmpeg

from mimeline.errors import BadFile
from mimeline.media.confined import Outcome, run_confined
from mimeline.media.limits import Limits, Refused

CONTAINERS = ("mov", "matroska", "avi", "mpegts", "nut")  # none of them points to other files
DECODERS = (
    *("h264", "hevc", "libdav1d", "av1", "libvpx", "libvpx-vp9", "vp8", "vp9"),
    *("mpeg4", "msmpeg4", "msmpeg4v2", "msmpeg4v3", "mpeg2video", "mpeg1video", "h263"),
    *("mjpeg", "prores", "dnxhd", "dvvideo", "ffv1", "rawvideo", "huffyuv", "ffvhuff", "png"),
    *("aac", "mp3", "mp3float", "mp2", "mp2float", "ac3", "eac3", "opus", "libopus", "vorbis"),
    *("libvorbis", "flac", "alac", "pcm_s16le", "pcm_s16be", "pcm_s24le", "pcm_s32le"),
    *("pcm_s24be", "pcm_f32le", "pcm_u8", "pcm_alaw", "pcm_mulaw", "adpcm_ima_wav", "adpcm_ms"),
)
SAYINGS = {  # libav's words → ours
    "moov atom not found": "a video without its index (moov): it was cut off, or not closed",
    "error reading header": "a video whose header is cut off or spoilt",
    "Format not on whitelist": "a file of another kind",
    "Invalid data found when processing input": "no video that can be opened",
    "End of file": "a video that ends before its first picture",
    "Cannot allocate memory": "a video that asks for too much memory",
    "memory": "a video that asks for too much memory",
}
BITEXACT = {"map_metadata": -1, "map_chapters": -1, "fflags": "+bitexact", "flags": "+bitexact"}


def open_input(path: Path, limits: Limits, **options):
    """An input of an ffmpeg graph. options: ffmpeg's, for this input."""
    return ffmpeg.input(
        name_of(path),
        protocol_whitelist="file,pipe",
        format_whitelist=",".join(CONTAINERS),
        codec_whitelist=",".join(DECODERS),
        max_pixels=2 * limits.max_pixels,  # decoders count their padding
        threads=1,
        **options,
    )


def write(streams: Sequence, source: Path, target: Path, limits: Limits, **options) -> None:
    """Run ffmpeg on the streams of a graph that reads source, and write them to target.

    options: ffmpeg's, for the output. The same input gives the same bytes. A part of target may be
    left where it fails.
    Raises BadFile with ffmpeg's last word; Refused if it takes too long (timed_out) or the new
    file grows too large (too_many_bytes); OSError if the disk is full.
    """
    graph = ffmpeg.output(*streams, name_of(target), **BITEXACT, threads=1, **options)
    graph = graph.global_args("-nostdin", "-hide_banner", "-loglevel", "error")
    graph = graph.global_args("-filter_threads", "1")
    command = graph.compile(cmd=imageio_ffmpeg.get_ffmpeg_exe(), overwrite_output=True)
    outcome = run_confined(command, source, limits, file_bytes=limits.max_bytes)
    if outcome.code == -signal.SIGXFSZ:
        raise Refused(
            source,
            rule="too_many_bytes",
            value=limits.max_mb,
            limit=limits.max_mb,
            unit="MB",
            found=f"more than {limits.max_mb:g} MB to write",
            expected="at most that",
            remedy="Shorten the clip, or raise fetch.max_mb.",
        )
    if outcome.code:
        raise BadFile(
            source,
            found=f"a video that ffmpeg stops at ({_last_word(outcome)})",
            expected="a video that can be decoded",
            remedy="Look whether the file plays; take it again.",
        )


def name_of(path: Path) -> str:
    """A path as ffmpeg takes it, whatever characters it holds."""
    return f"file:{Path(path).absolute()}"


def in_our_words(complaint: str) -> str | None:
    """What libav complains of, where we know to say it better."""
    return next((ours for theirs, ours in SAYINGS.items() if theirs in complaint), None)


def _last_word(outcome: Outcome) -> str:
    if outcome.code < 0:
        return signal.Signals(-outcome.code).name
    lines = [line.strip() for line in outcome.complaint.splitlines() if line.strip()]
    return lines[-1] if lines else "no reason given"
