"""Tabs of a Chromium, with all that they asked for and complained of."""

import os
import re
import time
from pathlib import Path

from playwright.sync_api import BrowserContext, ConsoleMessage, Page, expect

WIDE = {"width": 1400, "height": 860}
MOST_MS = 30_000  # to wait for anything; nothing takes nearly as long
POLL_MS = 20
SLOW = "GPU stall due to ReadPixels"  # what a machine without one is told of WebGL
expect.set_options(timeout=MOST_MS)


class Tabs:
    """Tabs that share their cookies, as those of one person do."""

    def __init__(self, context: BrowserContext):
        self.context = context
        self.requested: list[str] = []
        self.complaints: list[str] = []
        context.set_default_timeout(MOST_MS)
        context.on("request", lambda request: self.requested.append(request.url))
        context.on("console", self._heard)
        context.on("weberror", lambda error: self.complaints.append(str(error.error)))

    def open(self, address: str) -> Page:
        page = self.context.new_page()
        page.goto(address)
        page.wait_for_url(lambda url: "key=" not in url)  # it became a cookie
        return page

    def expect(self, complaint: str) -> None:
        """A complaint that is meant to be: a pattern that the console's whole line fits."""
        assert [one for one in self.complaints if re.fullmatch(complaint, one)], self.complaints
        self.complaints = [one for one in self.complaints if not re.fullmatch(complaint, one)]

    def asked_elsewhere(self) -> list[str]:
        """What was asked for that is not of a page on this machine."""
        return [url for url in self.requested if not url.startswith("http://127.0.0.1:")]

    def _heard(self, message: ConsoleMessage) -> None:
        if message.type in ("error", "warning") and SLOW not in message.text:
            self.complaints.append(message.text)


def until(page: Page, holds: str, arg: object = None) -> None:
    """Wait until an expression holds in the page.

    holds: JavaScript, or a function of arg. Playwright's own wait evaluates text within the page,
    which the pages' content policy refuses.
    """
    end = time.monotonic() + MOST_MS / 1000
    while not page.evaluate(holds, arg):
        assert time.monotonic() < end, f"it never holds: {holds}"
        page.wait_for_timeout(POLL_MS)


def take_picture(page: Page, name: str) -> None:
    """A picture of the page, to be looked at, where MIMELINE_SCREENSHOTS names a folder."""
    if folder := os.environ.get("MIMELINE_SCREENSHOTS"):
        page.screenshot(path=Path(folder) / f"{name}.png")
