import errno
import io
from email.message import Message

import pytest

pytest.importorskip("yt_dlp")

from yt_dlp.networking.common import Response
from yt_dlp.networking.exceptions import HTTPError, TransportError
from yt_dlp.utils import (
    ContentTooShortError,
    DownloadError,
    ExtractorError,
    GeoRestrictedError,
    UnsupportedError,
)

from mimeline.media.limits import Limits, Refused
from mimeline.media.remote import Gone, NotDownloaded, TurnedAway, Unreachable, fault
from mimeline.media.website import fault_of

PAGE = "http://x/watch?v=1"


def as_raised(error: Exception) -> DownloadError:
    """As yt-dlp hands on what goes wrong."""
    return DownloadError(f"ERROR: {error}", (type(error), error, None))


def of_status(status: int, url: str = PAGE, **headers: str) -> ExtractorError:
    message = Message()
    for name, value in headers.items():
        message[name.replace("_", "-")] = value
    cause = HTTPError(Response(io.BytesIO(), url, message, status))
    return ExtractorError(f"HTTP Error {status}: Not Found", cause=cause, expected=True)


@pytest.mark.parametrize(
    ("error", "kind"),
    [
        (ExtractorError("Video unavailable", expected=True), TurnedAway),
        (ExtractorError("Private video. Sign in if you have access", expected=True), Gone),
        (ExtractorError("This video has been removed by the uploader", expected=True), Gone),
        (ExtractorError("Sign in to confirm your age", expected=True), TurnedAway),
        (GeoRestrictedError("not in your country", countries=["AT"]), TurnedAway),
        (ExtractorError("Not for you", video_id="removed_1", expected=True), TurnedAway),
        (UnsupportedError("http://x/private"), NotDownloaded),
        (of_status(404), Gone),
        (of_status(410), Gone),
        (of_status(404, url="http://x/api"), TurnedAway),
        (of_status(403), TurnedAway),
        (of_status(401), TurnedAway),
        (ExtractorError("Sign in to confirm you're not a bot", expected=True), TurnedAway),
        (
            ExtractorError("Video unavailable. This content isn't available, try again later"),
            Unreachable,
        ),
        (ExtractorError("This page tells of an image", expected=True), TurnedAway),
        (of_status(429), Unreachable),
        (of_status(503, url="http://x/api"), Unreachable),
        (ExtractorError("Unable to download", cause=TransportError("timed out")), Unreachable),
        (ExtractorError("Unable to extract player version"), NotDownloaded),
        (KeyError("formats"), NotDownloaded),
    ],
    ids=lambda value: value.__name__ if isinstance(value, type) else str(value)[:40],
)
def test_what_sites_say_is_told_apart(error, kind):
    said = fault_of(as_raised(error), PAGE)
    assert type(fault(PAGE, Limits(), **said)) is kind


@pytest.mark.parametrize(
    ("error", "found"),
    [
        (of_status(503), "the answer 503 ("),
        (of_status(404, url="http://x/api"), "the answer 404 (Not Found) where the page leads to"),
        (ContentTooShortError(10, 40), "a server that broke off after 10 of 40 bytes"),
        (TransportError("[Errno 111] Connection refused"), "a server that refused the connection"),
        (ExtractorError("Private video", video_id="v1", ie="youtube", expected=True), "Private"),
        (UnsupportedError("http://x/"), "a page on which yt-dlp finds no video"),
        (KeyError("formats"), "a page that yt-dlp fails on ('formats')"),
    ],
    ids=str,
)
def test_what_went_wrong_is_said_in_plain_words(error, found):
    raised = fault(PAGE, Limits(), **fault_of(as_raised(error), PAGE))
    assert raised.found.startswith(found)


def test_a_server_that_asks_to_wait_is_heard():
    said = fault_of(as_raised(of_status(429, Retry_After="7")), PAGE)
    assert fault("http://x/", Limits(), **said).retry_after_s == 7.0


def test_a_full_disk_is_an_error_of_the_run_and_a_large_file_one_of_the_source():
    full = fault_of(as_raised(OSError(errno.ENOSPC, "No space left on device")), PAGE)
    assert fault("http://x/", Limits(), **full).errno == errno.ENOSPC
    large = fault_of(as_raised(OSError(errno.EFBIG, "File too large")), PAGE)
    assert isinstance(fault("http://x/", Limits(), **large), Refused)
