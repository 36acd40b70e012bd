"""The child that asks a site for a video through yt-dlp; says a line of JSON."""

import contextlib
import errno
import json
import re
import sys
from collections.abc import Iterator
from urllib.parse import unquote, urlsplit

import yt_dlp
from yt_dlp.networking.exceptions import HTTPError, TransportError
from yt_dlp.utils import (
    ContentTooShortError,
    DownloadError,
    ExtractorError,
    UnsupportedError,
)

from mimeline.media.plain_words import answered, in_plain_words
from mimeline.media.private_hosts import stay_out
from mimeline.media.ranges import retry_after_s

# What sites say: the first list is of the moment, the second for good. All else ("unavailable",
# "sign in") they also say to those who ask too often.
PASSING = ("try again", "too many requests", "temporar")
LASTING = (
    *("private", "removed", "deleted", "terminated", "taken down", "no longer available"),
    *("does not exist", "doesn't exist", "drm protect"),
)

PART = re.compile(r"^\[[\w:.+-]+\] ")

BUFFER = 1 << 16  # bytes: what of them has come when a connection breaks is lost


class TooLarge(Exception):
    pass


class Said(Exception):
    """A fault that we find ourselves."""

    def __init__(self, fault: str, said: str):
        self.fault = fault
        super().__init__(said)


class Quiet:
    """What yt-dlp says on the way; its errors come as exceptions."""

    def debug(self, text: str) -> None: ...

    def warning(self, text: str) -> None: ...

    def error(self, text: str) -> None: ...


def main() -> None:
    task = json.loads(sys.argv[1])
    stay_out(task["address"])
    with contextlib.redirect_stdout(sys.stderr):
        try:
            facts = asked(**task)
        except Exception as error:
            facts = fault_of(error, task["address"])
    print(json.dumps(facts))


def asked(
    address: str,
    target: str | None,
    max_height: int,
    max_pixels: int,
    max_source_s: float,
    max_bytes: int,
    stall_s: float,
    ffmpeg: str,
) -> dict:
    """Where pictures and sound of a video lie; or, with a target, the path of its download.

    target: path without ending. A download that was broken off is taken up.
    A video beyond the limits is not downloaded: then there is neither.
    """

    def watched(progress: dict) -> None:
        if progress.get("downloaded_bytes", 0) > max_bytes:
            raise TooLarge

    low = f"[height<=?{max_height}]"
    options = {
        "format": f"bv*{low}+ba/b{low}/bv*+ba/b",
        "format_sort": [f"res:{max_height}", "fps", "proto"],
        "outtmpl": {"default": f"{target or 'nothing'}".replace("%", "%%") + ".%(ext)s"},
        "noplaylist": True,
        "playlist_items": "1",
        "cachedir": False,
        "continuedl": True,
        **{"buffersize": BUFFER, "noresizebuffer": True},
        "updatetime": False,
        "socket_timeout": stall_s,
        **dict.fromkeys(("retries", "fragment_retries", "extractor_retries"), 0),
        "file_access_retries": 0,
        "skip_unavailable_fragments": False,
        "hls_prefer_native": True,
        "external_downloader": {"default": "native"},
        "ffmpeg_location": ffmpeg,
        "logger": Quiet(),
        "noprogress": True,
        "progress_hooks": [watched],
    }
    with yt_dlp.YoutubeDL(options) as site:
        info = site.extract_info(address, download=False)
        if info.get("_type", "video") != "video":
            raise Said("gone", "an address of several videos")
        if info.get("is_live"):
            raise Said("refused", "a broadcast that goes on")
        parts = info.get("requested_formats") or [info]
        facts = {
            "width": max(part.get("width") or 0 for part in parts),
            "height": max(part.get("height") or 0 for part in parts),
            "length_s": info.get("duration") or 0,
            "bytes": sum(part.get("filesize") or 0 for part in parts),
        }
        many = facts["width"] * facts["height"] > max_pixels
        if many or facts["length_s"] > max_source_s or facts["bytes"] > max_bytes:
            return facts
        if target is None:
            if any(part.get("protocol") not in ("http", "https") for part in parts):
                raise Said("declined", "a video that comes in fragments")
            return facts | {"parts": [[p["url"], p.get("http_headers") or {}] for p in parts]}
        try:
            done = site.process_ie_result(site.sanitize_info(info, True), download=True)
        except DownloadError as error:
            # A site's own address of a file serves for a while: a new one may be better.
            status = next((e.status for e in causes(error) if isinstance(e, HTTPError)), None)
            if status is not None and status < 500 and status != 429:
                raise Said("passing", answered(status, None)) from error
            raise
        return facts | {"path": done["requested_downloads"][0]["filepath"]}


def fault_of(error: Exception, page: str) -> dict:
    """What is wrong, in the words of `remote.fault`.

    page: the address that was looked through. What another that it needs answers is not said of it.
    """
    chain = list(causes(error))
    said = in_short(next((e for e in chain if isinstance(e, ExtractorError)), error))
    low = said.lower()
    numbers = {e.errno for e in chain if isinstance(e, OSError)}
    if numbers & {errno.ENOSPC, errno.EDQUOT}:
        return {"fault": "full", "said": said}
    if errno.EFBIG in numbers or any(isinstance(e, TooLarge) for e in chain):
        return {"fault": "large", "said": said}
    for e in chain:
        if isinstance(e, Said):
            return {"fault": e.fault, "said": str(e)}
        if isinstance(e, HTTPError):
            wait_s = retry_after_s(e.response.headers)
            facts = {"fault": "answered", "status": e.status, "retry_after_s": wait_s}
            reply = answered(e.status, e.reason)
            if e.status > 499 or e.status == 429 or same(e.response.url, page):
                return facts | {"said": reply}
            said = f"{reply} where the page leads to"
    if any(isinstance(e, UnsupportedError) for e in chain):
        return {"fault": "stumped", "said": "a page on which yt-dlp finds no video"}
    if any(words in low for words in PASSING):
        return {"fault": "passing", "said": said}
    if any(isinstance(e, TransportError | ContentTooShortError | OSError) for e in chain):
        plain = (in_plain_words(raw) for raw in (said, *map(str, chain)))
        return {"fault": "passing", "said": next((w for w in plain if w is not None), said)}
    if any(isinstance(e, ExtractorError) and e.expected for e in chain):
        lasting = any(words in low for words in LASTING)
        return {"fault": "gone" if lasting else "refused", "said": said}
    if all(isinstance(e, DownloadError) for e in chain):
        return {"fault": "passing", "said": in_plain_words(said) or said}
    return {"fault": "stumped", "said": f"a page that yt-dlp fails on ({said})"}


def same(one: str, other: str) -> bool:
    """Whether two addresses are one, however they are quoted and whatever the scheme."""
    parts = (urlsplit(unquote(address)) for address in (one, other))
    return len({(part.netloc.lower(), part.path or "/", part.query) for part in parts}) == 1


def causes(error: BaseException | None) -> Iterator[BaseException]:
    """The error and all that led to it."""
    seen = set()
    todo = [error]
    while todo:
        error = todo.pop(0)
        if error is None or id(error) in seen:
            continue
        seen.add(id(error))
        yield error
        inner = getattr(error, "exc_info", None) or (None, None)
        todo += [inner[1], getattr(error, "cause", None), error.__cause__, error.__context__]


def in_short(error: Exception) -> str:
    """yt-dlp's sentence without its names for its parts and its advice to developers."""
    text = str(getattr(error, "orig_msg", error)).removeprefix("ERROR: ")
    text = PART.sub("", " ".join(text.split()))
    return text.partition("; please report this issue")[0][:300] or type(error).__name__


if __name__ == "__main__":
    main()
