"""What a video file holds, found out in a child process that cannot hang or harm this one."""

import json
import signal
import stat
import sys
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import BinaryIO

import numpy as np

from mimeline.errors import BadFile, unreadable
from mimeline.media import demux
from mimeline.media.confined import run_confined
from mimeline.media.ffmpeg import CONTAINERS, DECODERS, in_our_words
from mimeline.media.limits import Limits, Refused, check_bytes, check_video
from mimeline.media.signature import kind_of

FASTEST = 1000  # frames per second; a file with more of them is no video of a face
TIME_BYTES, FACTS_BYTES = 8, 1 << 20  # of a frame's time; of all else that the child says
EXPECTED = "a video: MP4, QuickTime, Matroska, WebM, AVI or MPEG-TS"


@dataclass(frozen=True)
class Probe:
    """What a video file holds. Sizes are as shown: turned upright, pixels square.

    stream: number of the video stream in the file. rate: frames per second, on average.
    times: (n_frames,) seconds of every frame on the file's own clock, in the order shown.
    frame_s: how long a frame usually lasts. ordered: the file tells the time of each frame, so
    that it can be entered anywhere. since_s: where seconds are counted from on that clock: the
    first frame's time, and of a piece that was copied out of a video, the video's. ahead_s: how far
    the piece's clock is ahead of the video's. first_frame: its first frame's number in the video;
    None where that is not known.
    """

    container: str
    codec: str
    stream: int
    width: int
    height: int
    rate: Fraction
    times: np.ndarray
    frame_s: float
    sound_stream: int | None
    pixel_shape: float
    ordered: bool
    since_s: float
    ahead_s: float = 0.0
    first_frame: int | None = 0

    @property
    def n_frames(self) -> int:
        return len(self.times)

    @property
    def has_sound(self) -> bool:
        return self.sound_stream is not None

    @property
    def duration_s(self) -> float:
        """From the first frame shown, of the whole video, to the end of the last."""
        return float(self.times[-1] - self.since_s) + self.frame_s

    @property
    def variable(self) -> bool:
        """Frames last unequally long, by more than the rounding of their times."""
        gaps = np.diff(self.times)
        return bool(len(gaps) and gaps.max() - gaps.min() > max(0.0025, 0.1 * self.frame_s))


def probe(path: Path, limits: Limits) -> Probe:
    """Look into a video file without trusting it.

    Raises NoSuchFile; Refused if it is larger or longer than the limits or takes too long; BadFile
    if it is no video that can be read, saying what it is instead; RuntimeError if the child fails
    for another reason than the file.
    """
    path = Path(path)
    with _opened(path, limits) as file:
        facts, ticks = _demux(path, file, limits)
    tick = Fraction(*facts["time_base"])
    times = np.sort(ticks).astype(np.float64) * tick.numerator / tick.denominator
    width, height = _shown(facts)
    claimed_s = max(facts["claimed_s"], float(np.ptp(times)) if len(times) else 0.0)
    check_video(path, width, height, claimed_s, limits)
    ordered = not (facts["container"] == "avi" and facts["codec"] in ("h264", "hevc"))
    if not ordered:  # AVI has no times of presentation; those of reordered frames are guesses
        times -= times[0]
    gaps = np.diff(times)
    rate = Fraction(*facts["rate"])
    if not len(gaps) and not rate:
        raise _bad(path, "a single picture without a rate")
    typical_s = float(np.median(gaps)) if len(gaps) else float(1 / rate)
    if typical_s <= 0:
        raise _bad(path, "frames that have no times of their own")
    return Probe(
        container=facts["container"],
        codec=facts["codec"],
        stream=facts["stream"],
        width=width,
        height=height,
        rate=rate or Fraction(1 / typical_s).limit_denominator(1001),
        times=times,
        frame_s=typical_s,
        sound_stream=facts["sound"][0][0] if facts["sound"] else None,
        pixel_shape=facts["pixel_shape"],
        ordered=ordered,
        since_s=float(times[0]),
    )


def _opened(path: Path, limits: Limits) -> BinaryIO:
    """The file at its start, without a buffer: a child reads on from where we stand."""
    try:
        status = path.stat()
        if not stat.S_ISREG(status.st_mode):
            raise _bad(path, "no regular file")
        check_bytes(path, status.st_size, limits)
        file = path.open("rb", buffering=0)
        head = file.read(512)
        file.seek(0)
    except OSError as error:
        raise unreadable(path, error, expected=EXPECTED, remedy="Check the path.") from error
    if kind := kind_of(head):
        file.close()
        raise _bad(path, kind)
    return file


def _demux(path: Path, file: BinaryIO, limits: Limits) -> tuple[dict, np.ndarray]:
    """The child's facts and the frames' times in ticks, in stored order."""
    options = {
        "format_whitelist": ",".join(CONTAINERS),
        "codec_whitelist": ",".join(DECODERS),
        "protocol_whitelist": "file,pipe",
    }
    most = int(limits.max_source_s * FASTEST)
    arguments = json.dumps([options, limits.max_pixels, most])
    outcome = run_confined(
        [sys.executable, "-P", demux.__file__, arguments],  # not its folder's modules, but ours
        path,
        limits,
        file_bytes=most * TIME_BYTES + FACTS_BYTES,
        stdin=file,
    )
    if outcome.code < 0:
        name = signal.Signals(-outcome.code).name
        raise _bad(path, f"a video that the decoder breaks on ({name})")
    if outcome.code:
        raise RuntimeError(f"the child that looks into videos fails: {outcome.complaint}")
    head, _, tail = outcome.said.partition(b"\n")
    facts = json.loads(head)
    if "error" in facts:
        found = in_our_words(facts["error"]) or f"a file that cannot be opened ({facts['error']})"
        raise _bad(path, found)
    if facts.get("none") == demux.TOO_MANY_FRAMES:
        raise Refused(
            path,
            rule="too_many_frames",
            value=most + 1,
            limit=most,
            unit="frames",
            found=f"more than {most} frames",
            expected=f"at most {FASTEST} in a second",
            remedy="Convert the video to an ordinary rate.",
        )
    if "none" in facts:
        nothing = {
            demux.SOUND_ONLY: "sound without pictures",
            demux.NO_VIDEO: "a container without video",
            demux.NO_SIZE: "a video whose pictures have no size, or an impossible one",
            demux.NO_PICTURE: "a video of which no picture can be decoded",
        }
        raise _bad(path, nothing[facts["none"]])
    for codec in (facts["codec"], *(name for _, name in facts["sound"])):
        if codec not in DECODERS:
            raise BadFile(
                path,
                found=f"the codec {codec}",
                expected="a usual one, such as H.264 with AAC",
                remedy="Convert the video.",
            )
    return facts, np.frombuffer(tail, np.int64)


def _shown(facts: dict) -> tuple[int, int]:
    """Width and height with square pixels, turned as the file asks."""
    width = round(facts["width"] * facts.get("pixel_shape", 1.0))
    height = facts["height"]
    return (height, width) if facts.get("rotation", 0) % 180 else (width, height)


def _bad(path: Path, found: str) -> BadFile:
    return BadFile(path, found=found, expected=EXPECTED, remedy="Take the video again.")
