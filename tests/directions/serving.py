"""A server on this machine that answers as a language model's would, or as nobody should."""

import json
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

GOOD = {"seconds": 2, "actions": [{"action": "Smile", "start_s": 0.5, "end_s": 1.5}]}


@dataclass
class Served:
    """address: to name as the endpoint. asked: what came in, in order: path, headers, body."""

    address: str
    asked: list[tuple[str, dict[str, str], Any]] = field(default_factory=list)


def chat(content: Any) -> bytes:
    """A chat completion that says it."""
    said = content if isinstance(content, str) else json.dumps(content)
    return json.dumps({"choices": [{"message": {"role": "assistant", "content": said}}]}).encode()


@contextmanager
def serving(*answers: bytes | Callable[[BaseHTTPRequestHandler], None]) -> Iterator[Served]:
    """Serves the answers in turn, the last one ever after: bytes with 200, or what a handler is
    told to do."""

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            body = self.rfile.read(int(self.headers["Content-Length"]))
            served.asked.append((self.path, dict(self.headers), json.loads(body)))
            answer = answers[min(len(served.asked), len(answers)) - 1]
            if callable(answer):
                answer(self)
            else:
                reply(200, answer)(self)

        do_GET = do_POST

        def log_message(self, *_: Any) -> None:
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    server.daemon_threads = True
    served = Served(f"http://127.0.0.1:{server.server_port}/v1")
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
    thread.start()
    try:
        yield served
    finally:
        server.shutdown()
        thread.join()
        server.server_close()


def reply(code: int, body: bytes, **headers: str) -> Callable[[BaseHTTPRequestHandler], None]:
    def answer(handler: BaseHTTPRequestHandler) -> None:
        handler.send_response(code)
        for name, value in headers.items():
            handler.send_header(name, value)
        handler.send_header("Content-Length", str(len(body)))
        handler.end_headers()
        handler.wfile.write(body)

    return answer


def hang_up(handler: BaseHTTPRequestHandler) -> None:
    handler.wfile.write(b"HTTP/1.0 200 OK\r\nContent-Length: 1000\r\n\r\n{")
    handler.close_connection = True


def drip(handler: BaseHTTPRequestHandler) -> None:
    handler.wfile.write(b"HTTP/1.0 200 OK\r\nContent-Length: 40\r\n\r\n")
    with suppress(OSError):  # whoever asked has gone
        for _ in range(40):
            handler.wfile.write(b"{")
            time.sleep(0.02)


def babble(handler: BaseHTTPRequestHandler) -> None:
    handler.wfile.write(b"\x00\xffnothing that HTTP knows\r\n\r\n")
    handler.close_connection = True
