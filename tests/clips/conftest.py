"""A web server on this machine that misbehaves as it is told, and counts."""

import threading
from dataclasses import dataclass, field
from fractions import Fraction
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import numpy as np
import pytest

from mimeline.media.film import write_film


@dataclass
class Page:
    """What lies at a path, and how it is given.

    answers: status of each request in turn, the last one for all that follow. cut_off_at: a request
    whose answer would pass that byte of the body ends there, for the first `faults` of them; with
    stalls it falls silent instead.
    """

    body: bytes = b""
    answers: tuple[int, ...] = (200,)
    ranges: bool = True
    cut_off_at: int | None = None
    faults: int = 0
    stalls: bool = False
    headers: dict[str, str] = field(default_factory=dict)


class Web:
    """pages: path → Page. asked: (path, status, first byte, bytes sent) of every request."""

    def __init__(self):
        self.pages: dict[str, Page] = {}
        self.asked: list[tuple[str, int, int, int]] = []
        self.closing = threading.Event()
        web = self

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_GET(self):
                web.answer(self)

            def log_message(self, *_):
                pass

        self.server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.server.daemon_threads = True
        threading.Thread(target=self.server.serve_forever, args=[0.05], daemon=True).start()

    def put(self, path: str, body: bytes = b"", **how) -> None:
        """how: as of Page."""
        self.pages[path] = Page(body, **how)

    def address(self, path: str) -> str:
        return f"http://127.0.0.1:{self.server.server_port}/{path}"

    def requests(self, path: str) -> list[tuple[int, int, int]]:
        """(status, first byte, bytes sent) of each request for a path."""
        return [what for at, *what in self.asked if at == path]

    def sent(self, path: str) -> int:
        return sum(n_bytes for *_, n_bytes in self.requests(path))

    def answer(self, request) -> None:
        path = request.path.lstrip("/")
        page = self.pages.get(path, Page(answers=(404,)))
        status = page.answers[min(len(self.requests(path)), len(page.answers) - 1)]
        body, since = page.body, 0
        if status == 200 and page.ranges and (asked := request.headers.get("Range")):
            first, _, last = asked.removeprefix("bytes=").partition("-")
            since, until = int(first), min(int(last or len(body)), len(body) - 1) + 1
            status, body = (206, body[since:until]) if since < until else (416, b"")
        request.send_response(status)
        if status == 206 and "Content-Range" not in page.headers:
            request.send_header("Content-Range", f"bytes {since}-{until - 1}/{len(page.body)}")
        for name, value in page.headers.items():
            request.send_header(name, value)
        request.send_header("Content-Length", str(len(body) if status in (200, 206) else 0))
        request.send_header("Connection", "close")
        request.end_headers()
        request.close_connection = True
        broken = page.faults and status in (200, 206) and since + len(body) > page.cut_off_at
        if broken:
            page.faults -= 1
            body = body[: max(0, page.cut_off_at - since)]
        body = body if status in (200, 206) else b""
        self.asked.append((path, status, since, len(body)))
        try:
            request.wfile.write(body)
            request.wfile.flush()
        except OSError:  # the other side has seen enough
            return
        if broken and page.stalls:
            self.closing.wait(10)

    def close(self) -> None:
        self.closing.set()
        self.server.shutdown()
        self.server.server_close()


@pytest.fixture
def web():
    web = Web()
    yield web
    web.close()


@pytest.fixture(scope="session")
def film(tmp_path_factory) -> bytes:
    """24 s of film with sound, some 1.5 MB at 30 frames per second; frames brighten."""
    noise = np.random.default_rng(0)
    path = tmp_path_factory.mktemp("film") / "film.mp4"

    def pictures():
        for number in range(720):
            picture = np.full((64, 96, 3), 40 + number // 4, np.uint8)
            picture[32:] = noise.integers(0, 255, (32, 96, 3))
            yield picture

    write_film(path, pictures(), Fraction(30), np.sin(np.arange(24 * 16_000) / 6))
    return path.read_bytes()
