"""Videos on web servers: what stands in the way of one, and a few seconds of it."""

import errno
import json
import logging
import signal
import sys
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

from mimeline.errors import MimelineError
from mimeline.media import excerpt
from mimeline.media.confined import FULL, run_confined
from mimeline.media.ffmpeg import CONTAINERS, DECODERS
from mimeline.media.limits import Limits, Refused, check_bytes, check_video
from mimeline.media.probe import Probe, probe

log = logging.getLogger(__name__)

FOR_GOOD = (404, 410, 451)  # not found, gone, forbidden by law
WAIT_AND_SEE = (408, 421, 425, 429)  # with all of 5xx: what a server says of the moment
EXPECTED = "a video at this address"

LONGEST_SAYING = 200  # characters


class NotTaken(MimelineError):
    """A video could not be had from where it lies. rule: the ledger's."""

    rule: str

    def __init__(self, address: str, found: str, remedy: str):
        super().__init__(address, found=found, expected=EXPECTED, remedy=remedy)


class Gone(NotTaken):
    """It is not there; asking again is no use."""

    rule = "gone"


class Unreachable(NotTaken):
    """It could not be reached now. retry_after_s: how long the server asks to wait, if it does."""

    rule = "unreachable"

    def __init__(self, address: str, found: str, retry_after_s: float | None = None):
        self.retry_after_s = retry_after_s
        super().__init__(address, found, "Type `snakemake -R fetch` later: it is tried again.")


class TurnedAway(Unreachable):
    """We do not get it now, and shall not by asking at once; in another run we may."""


class NotDownloaded(NotTaken):
    """yt-dlp does not come to terms with the site."""

    rule = "not_downloaded"


class Broken(NotTaken):
    """The file that lies there came whole, and no video can be read out of it."""

    rule = "unreadable"

    def __init__(self, address: str, found: str):
        remedy = "Put one that plays in fetch.folder; `snakemake -R fetch` asks once more."
        super().__init__(address, found, remedy)


class Declined(Exception):
    """No piece can be taken; the whole video may be."""


@dataclass(frozen=True)
class Address:
    """Where pictures or sound lie, and the headers that the server wants with each request."""

    url: str
    headers: dict[str, str]


def take_piece(
    origin: str,
    pictures: Address,
    sound: Address | None,
    since_s: float,
    until_s: float,
    target: Path,
    limits: Limits,
    stall_s: float,
) -> tuple[Probe, float]:
    """Copy seconds of a video into target (NUT), transferring hardly more than these.

    origin: the address that the user named; it led to those of pictures and sound.
    sound: None where the pictures bring it.
    since_s, until_s: counted from the first frame shown.
    stall_s: how long the server may be silent, seconds.
    Returns what target holds, on the clock of the whole video, and the whole video's length in
    seconds. Raises Declined if the piece would not equal one cut of the whole video; Gone,
    Unreachable; Refused if the video breaks the limits; OSError if the disk is full.
    """
    task = {
        "origin": origin,
        "pictures": {"address": pictures.url, "headers": pictures.headers},
        "sound": sound and {"address": sound.url, "headers": sound.headers},
        "since_s": since_s,
        "until_s": until_s,
        "target": str(target),
        "stall_s": stall_s,
        "most": [limits.max_pixels, limits.max_source_s],
        "options": {
            "format_whitelist": ",".join(CONTAINERS),
            "codec_whitelist": ",".join(DECODERS),
            "protocol_whitelist": "",
        },
    }
    facts = told_by(excerpt.__file__, task, origin, limits)
    check_video(origin, facts["width"], facts["height"], facts["claimed_s"], limits)
    piece = probe(target, limits)
    if piece.n_frames != facts["n_frames"]:
        raise Declined(f"{piece.n_frames} frames of {facts['n_frames']} in the piece")
    tick = Fraction(*facts["time_base"])

    def seconds(ticks: int) -> float:
        return ticks * tick.numerator / tick.denominator

    clock = {
        "since_s": seconds(facts["begin"] + facts["ahead"]),
        "ahead_s": seconds(facts["ahead"]),
        "first_frame": facts["first_frame"],
        "rate": Fraction(*facts["rate"]) or piece.rate,
    }
    return replace(piece, **clock), facts["claimed_s"]


def told_by(child: str, task: dict, address: str, limits: Limits) -> dict:
    """The line of JSON that a child says of an address; its fault is raised as an error."""
    arguments = [sys.executable, "-P", child, json.dumps(task)]
    try:
        outcome = run_confined(arguments, address, limits, file_bytes=limits.max_bytes)
    except Refused as error:
        raise TurnedAway(
            address, f"a server that takes more than {limits.timeout_s:g} s"
        ) from error
    if outcome.code < 0:
        raise TurnedAway(address, f"a child that ends by {signal.Signals(-outcome.code).name}")
    if outcome.code:  # a server that found a way to upset it must not end the run
        log.error("the child that asks %s fails: %s", address, outcome.complaint)
        last = outcome.complaint.strip().rpartition("\n")[2]
        raise TurnedAway(address, f"a child that fails ({last})")
    facts = json.loads(outcome.said)
    if "fault" in facts:
        raise fault(address, limits, **facts)
    return facts


def fault(
    address: str,
    limits: Limits,
    fault: str,
    said: str,
    status: int | None = None,
    retry_after_s: float | None = None,
) -> Exception:
    """The error that a child speaks of.

    said: of the fault, perhaps in the server's own words. status: what the server answered for the
    address itself.
    """
    said = "".join(sign if sign.isprintable() else " " for sign in said[:LONGEST_SAYING])
    if fault == "full":
        return OSError(errno.ENOSPC, FULL)
    if fault == "large":
        try:
            check_bytes(address, limits.max_bytes + 1, limits)
        except Refused as error:
            return error
    if fault == "declined":
        return Declined(said)
    if fault == "stumped":
        return NotDownloaded(address, said, "Update yt-dlp (pip install -U yt-dlp); try again.")
    passing = fault == "passing" or (
        status is not None and (status in WAIT_AND_SEE or status > 499)
    )
    if passing:
        return Unreachable(address, said, retry_after_s)
    if fault == "gone" or status in FOR_GOOD:
        return Gone(address, said, "Leave its clips out, or put the video in fetch.folder.")
    return TurnedAway(address, said)
