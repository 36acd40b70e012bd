"""The child that copies a few seconds out of a video on a web server; says a line of JSON.

Packets are copied as they are, with the times that the video gives them, into a NUT file: it keeps
any clock exactly. What such a file would not keep makes the child decline.
"""

import heapq
import json
import sys
from collections.abc import Iterator
from contextlib import ExitStack

import av
import av.logging

from mimeline.media.demux import (
    FAULTS_OF_A_FILE,
    claimed_seconds,
    complaint,
    first_picture,
    is_cover,
)
from mimeline.media.private_hosts import stay_out
from mimeline.media.ranges import OF_THE_DISK, Answered, NoRanges, Passing, RemoteFile
from mimeline.media.signature import kind_of

LEAD_S = 1.0  # the order stored, by which a file is entered, runs ahead of the order shown
AHEAD_S = 2  # of the video's clock, that of a piece from its start
TAIL_S = 2.0  # pictures and sound of one time lie up to a second apart
REORDERED = 32  # frames after the first among which the earliest is looked for


class Declined(Exception):
    """The piece would not be as good as one of the whole file."""


def main() -> None:
    task = json.loads(sys.argv[1])
    av.logging.set_level(av.logging.ERROR)
    stay_out(task.pop("origin"))
    try:
        facts = copied(**task)
    except (Answered, Passing) as error:
        facts = error.facts
    except NoRanges:
        facts = {"fault": "declined", "said": "the server gives whole files only"}
    except Declined as error:
        facts = {"fault": "declined", "said": str(error)}
    except FAULTS_OF_A_FILE as error:
        facts = {"fault": OF_THE_DISK.get(getattr(error, "errno", None), "declined")}
        facts["said"] = complaint(error)
    print(json.dumps(facts))


def copied(
    pictures: dict,
    sound: dict | None,
    since_s: float,
    until_s: float,
    target: str,
    stall_s: float,
    most: list[float],
    options: dict[str, str],
) -> dict:
    """Copy since_s to until_s, counted from the first frame shown, and what it needs before.

    pictures, sound: {address, headers}; sound is None where the pictures bring their own.
    most: pixels and seconds of a video; of one beyond them, only the facts.
    Returns what the video tells of itself and the piece's clock: begin, the time of the video's
    first frame in ticks of time_base; ahead, how many ticks the piece's clock is ahead of the
    video's; first_frame, how many frames come before the piece, None where the video does not tell.
    """
    with ExitStack() as stack:

        def opened(file: RemoteFile):
            file.seek(0)
            return stack.enter_context(av.open(file, options=options, metadata_errors="replace"))

        file = RemoteFile(**pictures, stall_s=stall_s)
        if kind := kind_of(file.head):
            raise Answered(200, kind, None)
        container = opened(file)
        video = next((s for s in container.streams.video if not is_cover(s)), None)
        facts = told(container, video)
        if facts["width"] * facts["height"] > most[0] or facts["claimed_s"] > most[1]:
            return facts
        begin = first_shown(container, video)
        begin_s = float(begin * video.time_base)
        container = opened(file)  # from its start again: not every kind finds back there
        video = container.streams[video.index]
        others = opened(RemoteFile(**sound, stall_s=stall_s)) if sound else container
        audio = next(iter(others.streams.audio), None)
        together = [video] if sound or audio is None else [video, audio]

        at_start = since_s <= LEAD_S
        span_s = None if at_start else begin_s + since_s - LEAD_S, begin_s + until_s + TAIL_S
        parts = [packets(container, together, *span_s)]
        if sound and audio is not None:
            parts.append(packets(others, [audio], *span_s))
        times, key = [], None
        streams = [video] if audio is None else [video, audio]
        piece = stack.enter_context(Piece(target, streams, ahead_s=AHEAD_S if at_start else 0))
        for packet in heapq.merge(*parts, key=time_of):
            if packet.stream is video:
                if packet.is_discard:
                    raise Declined("frames that are not shown")
                if packet.is_corrupt:
                    raise file.fault or Declined("a packet is cut off")
                if key is None and packet.is_keyframe:
                    key = packet.pts, number_of(container, video, packet.dts)
                times.append(packet.pts)
            piece.add(packet)
    if key is None or seconds(key[0] - begin, facts) > since_s:
        raise Declined("no key frame to enter at")
    if seconds(max(times) - begin, facts) < min(until_s, facts["claimed_s"]) - TAIL_S:
        raise Declined("the video ends before it says")
    since, number = key
    before = sum(time < since for time in times)  # shown before the key frame, stored after it
    return facts | {
        "begin": begin,
        "ahead": piece.ahead[video],
        "first_frame": None if number is None else number + before,
        "n_frames": len(times) - before,
    }


def told(container, video) -> dict:
    """What a video tells of itself."""
    if video is None or video.codec_context is None:
        raise Declined("no video, or one of an unknown kind")
    if container.format.name == "avi":
        raise Declined("AVI does not tell when its frames are shown")
    claimed_s = claimed_seconds(container, video)
    if not claimed_s:
        raise Declined("the video does not tell its length")
    return {
        "time_base": video.time_base.as_integer_ratio(),
        "rate": (video.average_rate or 0).as_integer_ratio(),
        "claimed_s": claimed_s,
        "width": video.codec_context.width,
        "height": video.codec_context.height,
    }


def seconds(ticks: int, facts: dict) -> float:
    return ticks * facts["time_base"][0] / facts["time_base"][1]


class Piece:
    """The NUT file. ahead_s: added to all times, as at the start of a video some lie before zero,
    which NUT has no room for; ahead: the same in each stream's ticks."""

    def __init__(self, target: str, streams: list, ahead_s: int):
        options = {"avoid_negative_ts": "disabled"}
        self.file = av.open(target, "w", format="nut", options=options)
        self.copies = {s: self.file.add_stream_from_template(s, opaque=True) for s in streams}
        self.ticks = {s: s.time_base.denominator // s.time_base.numerator for s in streams}
        self.ahead = {s: ahead_s * self.ticks[s] for s in streams}
        self.stored: dict = {}

    def __enter__(self) -> "Piece":
        return self

    def __exit__(self, *_) -> None:
        self.file.close()

    def add(self, packet) -> None:
        stream = packet.stream
        if packet.dts is None:  # of the first ones: some kinds do not tell when they are decoded
            first = packet.pts - self.ticks[stream]
            packet.dts = self.stored[stream] = self.stored.get(stream, first) + 1
        packet.pts += self.ahead[stream]
        packet.dts += self.ahead[stream]
        if packet.dts < 0:
            raise Declined("times before zero")
        packet.stream = self.copies[stream]
        self.file.mux(packet)


def first_shown(container, video) -> int:
    """The time of the first frame shown, in ticks."""
    video.codec_context.thread_count = 1
    since, times, picture = None, [], None
    for packet in container.demux(video):
        picture = picture or first_picture(packet)
        if picture is not None and picture.rotation:
            raise Declined("turned pictures, which a NUT file cannot speak of")
        if not packet.size:
            break
        if packet.pts is None:
            raise Declined("frames without times")
        since = packet.pts if since is None and packet.is_keyframe else since
        if since is None:
            raise Declined("a video that does not begin with a key frame")
        if packet.pts >= since and not packet.is_discard:
            times.append(packet.pts)
        if len(times) > REORDERED and picture is not None:
            break
    if not times or picture is None:
        raise Declined("no picture")
    return min(times)


def packets(container, streams, enter_s: float | None, leave_s: float) -> Iterator:
    """Packets of the streams, from the key frame before enter_s until the first passes leave_s.

    enter_s: None for the start.
    """
    leader = streams[0]
    if enter_s is not None:
        container.seek(int(enter_s / leader.time_base), stream=leader)
    for packet in container.demux(*streams):
        if not packet.size or packet.pts is None:
            continue
        if packet.stream is leader and time_of(packet) > leave_s:
            return
        yield packet


def time_of(packet) -> float:
    """Seconds, in the order stored."""
    return float((packet.pts if packet.dts is None else packet.dts) * packet.time_base)


def number_of(container, video, dts: int) -> int | None:
    """How many frames are stored before the one of that time and shown; None: not told."""
    index = video.index_entries
    if not container.format.name.startswith("mov") or len(index) != video.frames:
        return None
    before = 0
    for entry in index:
        if entry.timestamp == dts:
            return before
        before += not entry.is_discard
    return None


if __name__ == "__main__":
    main()
