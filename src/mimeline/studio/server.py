"""The ground of every page: served on this machine alone, to the one who has its address.

The address that is printed holds a random key; opening it puts the key into a cookie. Each request
is checked for that cookie, for the host's name (a foreign site that lets its name point here is
refused) and for the page that it comes from. Pages run no script but ours and load nothing from
elsewhere. Films and sounds are served from a list, by name; no path comes from a request.
"""

import hashlib
import hmac
import logging
import os
import secrets
import signal
import socket
import sys
import webbrowser
from collections.abc import Callable, Mapping
from pathlib import Path
from urllib.parse import urlsplit

from flask import Blueprint, Flask, Response, abort, render_template, request, send_file
from jinja2 import StrictUndefined
from werkzeug.exceptions import HTTPException
from werkzeug.serving import WSGIRequestHandler, make_server

from mimeline.errors import MimelineError

log = logging.getLogger(__name__)

HOST = "127.0.0.1"
HOSTS = (HOST, "localhost")  # on any port: a tunnel from another machine may end on its own
KEY = "key"  # of the address
MOST_BYTES = 16_384  # of a post
TYPES = {".mp4": "video/mp4", ".wav": "audio/wav"}
CLOSED = "This page opens with the address that mimeline printed when it was started."

HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; "
    "img-src 'self'; media-src 'self'; connect-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'; require-trusted-types-for 'script'; trusted-types 'none'",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}

Media = Mapping[str, Mapping[str, Path]]


class PortTaken(MimelineError):
    """The page cannot be served on that port."""


def studio(page: Blueprint, media: Media, root: Path, key: str) -> Flask:
    """A page with its films, behind the checks that every page has.

    page: its routes. media: kind → name → file, all that `/media/<kind>/<name>` serves, and only
    while it lies under root, links followed. key: what the cookie has to hold.
    """
    app = Flask("mimeline.studio", root_path=str(Path(__file__).parent))
    app.config["MAX_CONTENT_LENGTH"] = MOST_BYTES
    app.jinja_env.autoescape = True  # whatever a template is called
    app.jinja_env.undefined = StrictUndefined
    app.register_error_handler(HTTPException, _refusal)
    app.register_error_handler(MimelineError, _problem)
    app.register_error_handler(RecursionError, _too_deep)
    app.before_request(lambda: _admit(key))
    app.after_request(_sealed)
    app.register_blueprint(page)
    root = root.resolve()

    @app.get("/media/<kind>/<name>")
    def media_file(kind: str, name: str) -> Response:
        path = media.get(kind, {}).get(name)
        if path is None or not (path := path.resolve()).is_relative_to(root):
            abort(404, "There is no such film or sound.")
        if path.suffix not in TYPES or not path.is_file():
            abort(404, f"{name} is no longer there: was the run changed meanwhile?")
        return send_file(
            path,
            mimetype=TYPES[path.suffix],
            download_name=f"{name}{path.suffix}",  # which need not be the file's
            conditional=True,
            etag=False,
        )

    return app


def serve(
    make: Callable[[str], Flask], port: int, open_browser: bool, say: Callable[[str], None]
) -> None:
    """Serve a page until Ctrl-C or a request to end. make: key → app. port: 0 for any that is free.

    say is told the address, which holds the key. Raises PortTaken.
    """
    key = secrets.token_urlsafe(32)
    app = make(key)
    with _listening(port) as listening:
        port = listening.getsockname()[1]
        server = make_server(
            HOST, port, app, threaded=True, request_handler=_Quiet, fd=listening.fileno()
        )
        server.daemon_threads = True  # a film that is being sent does not hold up the end
        address = f"http://{HOST}:{port}/?{KEY}={key}"
        say(f"{address}\n  Open it in a browser on this machine; Ctrl-C ends it.")
        if open_browser and _has_desktop():
            webbrowser.open(address)
        for end in (signal.SIGINT, signal.SIGTERM):  # scripts start what they leave deaf to Ctrl-C
            signal.signal(end, signal.default_int_handler)
        server.serve_forever()


def cookie_name(key: str) -> str:
    """Cookies are shared by all ports: two pages that run at once must not take the other's."""
    return f"mimeline-{hashlib.sha256(key.encode()).hexdigest()[:12]}"


def _admit(key: str) -> Response | None:
    """Refuse a request that is not of our own page; exchange the address's key for the cookie."""
    if _name_of(request.host) not in HOSTS:
        abort(403, f"This page is served to {HOST} alone, not to {request.host}.")
    if request.path == "/" and request.method == "GET" and KEY in request.args:
        if not _same(request.args[KEY], key):
            abort(403, CLOSED)
        return _enter(key)
    if not _same(request.cookies.get(cookie_name(key), ""), key):
        abort(403, CLOSED)
    if request.headers.get("Sec-Fetch-Site", "none") not in ("none", "same-origin"):
        abort(403, "Another page asked for this.")
    ours = f"{request.scheme}://{request.host}"
    writes = request.method not in ("GET", "HEAD")
    if request.headers.get("Origin", "" if writes else ours) != ours:
        abort(403, "Another page asked for this.")
    if writes and request.mimetype != "application/json":
        abort(415, "Posts are JSON.")
    return None


def _enter(key: str) -> Response:
    """Not a redirect: a browser that comes from another site would not show a strict cookie yet."""
    response = Response(render_template("enter.html"))
    response.set_cookie(cookie_name(key), key, httponly=True, samesite="Strict", path="/")
    return response


def _sealed(response: Response) -> Response:
    for name, value in HEADERS.items():
        response.headers[name] = value
    return response


def _refusal(error: HTTPException) -> Response:
    """In plain text, whatever the message quotes."""
    return Response(f"{error.description}\n", error.code, mimetype="text/plain")


def _problem(error: MimelineError) -> Response:
    return Response(f"{error}\n", 500, mimetype="text/plain")


def _too_deep(error: RecursionError) -> Response:
    """JSON that is nothing but brackets; pages post no such thing."""
    return Response("That is nested too deep.\n", 400, mimetype="text/plain")


def _same(given: str, key: str) -> bool:
    return hmac.compare_digest(given.encode(errors="replace"), key.encode())


def _name_of(host: str) -> str:
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""


def _listening(port: int) -> socket.socket:
    try:
        return socket.create_server((HOST, port))
    except (OSError, OverflowError) as error:
        raise PortTaken(
            f"{HOST}:{port}",
            found=str(error),
            expected="a free port",
            remedy="Give --port another number, or leave it out for any that is free.",
        ) from error


def _has_desktop() -> bool:
    """Without one a browser of the terminal would open and take it."""
    return sys.platform != "linux" or bool(
        os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    )


class _Quiet(WSGIRequestHandler):
    """Requests go to the log, not to the terminal; the server does not tell what it is made of."""

    def version_string(self) -> str:
        return "mimeline"

    def log(self, type: str, message: str, *arguments) -> None:
        log.debug(message, *arguments)
