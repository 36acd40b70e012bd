"""Requests to web servers; a file on one, read block by block where it is asked for."""

import email.utils
import errno
import io
import re
import time
import urllib.error
import urllib.request
from collections import OrderedDict
from collections.abc import Iterator
from contextlib import contextmanager
from http.client import HTTPException, HTTPMessage, HTTPResponse

from mimeline.media.plain_words import answered, broke_off, in_plain_words

BLOCK = 1 << 16  # bytes
MOST = 16  # blocks asked for at once: each time that reading goes on it is twice as many
KEPT = 64  # blocks: pictures and sound lie apart in some files, and are read in turn
GIVEN = re.compile(r"bytes ([0-9]{1,18})-[0-9]{1,18}/([0-9]{1,18})")  # Content-Range
OF_THE_DISK = {errno.ENOSPC: "full", errno.EDQUOT: "full", errno.EFBIG: "large"}


class NoRanges(Exception):
    """The server gives whole files only."""


class Passing(Exception):
    """The connection failed; it may hold another time."""

    @property
    def facts(self) -> dict:
        """In the words of `remote.fault`."""
        return {"fault": "passing", "said": str(self)}


class Answered(Exception):
    """The server says no. said: what it answers, or gives in the place of a video."""

    def __init__(self, status: int, said: str, retry_after_s: float | None):
        super().__init__(said)
        self.status, self.retry_after_s = status, retry_after_s

    @property
    def facts(self) -> dict:
        """In the words of `remote.fault`."""
        facts = {"status": self.status, "retry_after_s": self.retry_after_s}
        return {"fault": "answered", "said": str(self)} | facts


class RemoteFile(io.RawIOBase):
    """A file at an address of http or https; what is read of it is fetched, and no more.

    stall_s: how long the server may be silent, seconds.
    fault: what broke the last read that failed, for those to whom the reader does not hand it on.
    Raises Answered, NoRanges or Passing, when opened and on each read.
    """

    fault: Exception | None = None

    def __init__(self, address: str, headers: dict[str, str], stall_s: float):
        self._address, self._headers, self._stall_s = address, headers, stall_s
        self._blocks: OrderedDict[int, bytes] = OrderedDict()
        self._position, self.size = 0, None
        self._next, self._ahead = 0, 1  # the block after the last one fetched; how many to fetch
        self.head = self._block(0)[:512]

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def tell(self) -> int:
        return self._position

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        since = {io.SEEK_SET: 0, io.SEEK_CUR: self._position, io.SEEK_END: self.size}[whence]
        self._position = max(0, since + offset)
        return self._position

    def readinto(self, buffer) -> int:
        if self._position >= self.size:
            return 0
        number, offset = divmod(self._position, BLOCK)
        found = self._block(number)[offset : offset + len(buffer)]
        buffer[: len(found)] = found
        self._position += len(found)
        return len(found)

    def _block(self, number: int) -> bytes:
        if number not in self._blocks:
            self._ahead = min(2 * self._ahead, MOST) if number == self._next else 1
            self._next = number + self._ahead
            try:
                body = self._fetched(number * BLOCK, self._next * BLOCK)
            except (Answered, NoRanges, Passing) as fault:
                self.fault = fault
                raise
            for place in range(self._ahead):
                self._blocks[number + place] = body[place * BLOCK : (place + 1) * BLOCK]
            while len(self._blocks) > KEPT:
                self._blocks.popitem(last=False)
        self._blocks.move_to_end(number)
        return self._blocks[number]

    def _fetched(self, since: int, until: int) -> bytes:
        headers = self._headers | {"Range": f"bytes={since}-{until - 1}"}
        try:
            with replying(self._address, headers, self._stall_s) as reply:
                first, size = given(reply)
                if first != since or size is None:
                    raise NoRanges
                body = reply.read(until - since)
        except Answered as error:
            if error.status == 416:
                raise NoRanges from error
            raise
        if self.size not in (None, size):
            raise Passing(f"a file of {self.size} bytes has become one of {size}")
        self.size = size
        if len(body) < min(until, self.size) - since:
            raise Passing(broke_off(len(body), min(until, self.size) - since))
        return body


@contextmanager
def replying(address: str, headers: dict[str, str], stall_s: float) -> Iterator[HTTPResponse]:
    """What an address of http or https replies; redirects are followed, proxies are used.

    stall_s: how long the server may be silent, seconds.
    Raises Answered or Passing, also while the reply is read.
    """
    opener = urllib.request.OpenerDirector()  # the usual one opens local files too
    for handler in (
        *(urllib.request.ProxyHandler, urllib.request.HTTPHandler),
        *(urllib.request.HTTPSHandler, urllib.request.HTTPRedirectHandler),
        *(urllib.request.HTTPErrorProcessor, urllib.request.HTTPDefaultErrorHandler),
        urllib.request.UnknownHandler,
    ):
        opener.add_handler(handler())
    headers = headers | {"Accept-Encoding": "identity"}
    try:
        request = urllib.request.Request(address, headers=headers)
        with opener.open(request, timeout=stall_s) as reply:
            yield reply
    except urllib.error.HTTPError as error:
        said = answered(error.code, error.reason)
        raise Answered(error.code, said, retry_after_s(error.headers)) from error
    except (HTTPException, OSError, ValueError) as error:  # ValueError: whither it sends us
        if getattr(error, "errno", None) in OF_THE_DISK:
            raise
        said = str(error) or type(error).__name__
        raise Passing(in_plain_words(said) or said) from error


def given(reply: HTTPResponse) -> tuple[int | None, int | None]:
    """The first byte that a reply gives, and the bytes of the whole file; None: it does not tell.

    The first byte is None, too, of a reply that gives the whole file, whatever was asked for.
    """
    if reply.status == 206:
        told = GIVEN.fullmatch(reply.headers.get("Content-Range", "").strip())
        return (int(told[1]), int(told[2])) if told else (None, None)
    return None, reply.length


def retry_after_s(headers: HTTPMessage) -> float | None:
    """Seconds that a server asks to wait; None where it does not (RFC 9110, 10.2.3)."""
    said = headers.get("Retry-After", "").strip()
    if said.isdecimal():
        return float(said)
    try:
        return max(0.0, email.utils.parsedate_to_datetime(said).timestamp() - time.time())
    except (ValueError, OverflowError):
        return None
