"""The child that opens a video for `probe`: the file is its standard input, its only import av.

Says a line of JSON, then the presentation time of every frame as a 64-bit integer.
"""

import array
import json
import sys
from collections.abc import Sequence

import av
import av.logging

SOUND_ONLY, NO_VIDEO, NO_SIZE, NO_PICTURE = "sound", "nothing", "no size", "no picture"
TOO_MANY_FRAMES = "frames"
FAULTS_OF_A_FILE = (av.FFmpegError, MemoryError, UnicodeError, ArithmeticError)


def main() -> None:
    options, max_pixels, max_frames = json.loads(sys.argv[1])
    av.logging.set_level(av.logging.ERROR)
    try:
        with av.open(sys.stdin.buffer, options=options, metadata_errors="replace") as container:
            facts, times = read(container, max_pixels, max_frames)
    except FAULTS_OF_A_FILE as error:
        facts, times = {"error": complaint(error)}, []
    sys.stdout.buffer.write(json.dumps(facts).encode() + b"\n" + array.array("q", times).tobytes())


def read(container, max_pixels: int, max_frames: int) -> tuple[dict, Sequence[int]]:
    """What the container says of its video, and the times of its frames, in stored order."""
    pictures = [s for s in container.streams.video if not is_cover(s)]
    if not pictures:
        return {"none": SOUND_ONLY if container.streams.audio else NO_VIDEO}, []
    stream = pictures[0]
    codec = stream.codec_context
    if codec is None:
        return {"none": NO_PICTURE}, []
    codec.thread_count = 1
    if not codec.width * codec.height:
        return {"none": NO_SIZE}, []
    facts = {
        "container": container.format.name.split(",")[0],
        "codec": codec.name,
        "stream": stream.index,
        "width": codec.width,
        "height": codec.height,
        "time_base": stream.time_base.as_integer_ratio(),
        "rate": (stream.average_rate or stream.guessed_rate or 0).as_integer_ratio(),
        "claimed_s": claimed_seconds(container, stream),
        "sound": [[s.index, name_of_codec(s)] for s in container.streams.audio][:1],
    }
    if codec.width * codec.height > max_pixels:
        return facts, []
    times, first, since, whole = array.array("q"), None, None, 0
    for packet in container.demux(stream):
        if first is None and (first := first_picture(packet)) is not None:
            shape = stream.sample_aspect_ratio or codec.sample_aspect_ratio or 1
            facts |= {"width": first.width, "height": first.height}
            facts |= {"rotation": first.rotation, "pixel_shape": float(shape)}
        time = packet.dts if packet.pts is None else packet.pts
        if not packet.size or time is None:
            continue
        since = time if since is None and packet.is_keyframe else since
        if not packet.is_discard:
            times.append(time)
            whole = whole if packet.is_corrupt else len(times)
        if len(times) > max_frames:
            return {"none": TOO_MANY_FRAMES}, []
    # What comes before a key frame is not shown; what ends the file in the middle is no frame.
    times = [time for time in times[:whole] if since is not None and time >= since]
    if first is None or not times:
        return {"none": NO_PICTURE}, []
    return facts, times


def first_picture(packet):
    """A picture that the packet completes, or None; a spoilt packet gives none."""
    try:
        return next(iter(packet.decode()), None)
    except av.FFmpegError:
        return None


def complaint(error: Exception) -> str:
    """What libav says, the log's last line where it tells more than the error."""
    if isinstance(error, MemoryError):
        return "memory"
    if not isinstance(error, av.FFmpegError):
        return f"{type(error).__name__}: {error}"
    return (error.log[2] if error.log else error.strerror).strip()


def name_of_codec(stream) -> str:
    return stream.codec_context.name if stream.codec_context else "unknown"


def is_cover(stream) -> bool:
    return bool(stream.disposition & stream.disposition.__class__.attached_pic)


def claimed_seconds(container, stream) -> float:
    """The length that the headers give, the longest of what they say."""
    of_stream = float((stream.duration or 0) * stream.time_base)
    return max(of_stream, (container.duration or 0) / av.time_base)


if __name__ == "__main__":
    main()
