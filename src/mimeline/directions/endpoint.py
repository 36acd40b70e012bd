"""A language model behind an endpoint that speaks OpenAI's chat completions, as most servers do."""

import json
import time
import urllib.request
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from http.client import HTTPException, HTTPResponse
from typing import Any
from urllib.error import HTTPError, URLError
from urllib.parse import urlsplit

from mimeline.errors import MimelineError

MOST_BYTES = 2_000_000  # of an answer
TIMEOUT_S = 120.0  # a small model on a slow machine thinks for a while
SHOWN = 200  # characters of what a server says of its troubles
PIECE = 65_536  # bytes that are read at a time


class NoAnswer(MimelineError):
    """The endpoint cannot be reached, refuses, or does not say what a chat completion says."""


@dataclass(frozen=True)
class Endpoint:
    """address: up to /v1, as http://localhost:11434/v1. model: as the server calls it. key: of the
    user's account, empty for servers that ask for none."""

    address: str
    model: str
    key: str = field(default="", repr=False)

    def __post_init__(self):
        fault = _fault(self.address)
        if fault:
            raise NoAnswer(
                "--endpoint",
                found=fault,
                expected="an address as http://localhost:11434/v1",
                remedy="Name the server up to /v1; the rest is added. A key goes into the "
                "environment: MIMELINE_API_KEY.",
            )
        object.__setattr__(self, "key", self.key.strip())
        if not (self.key.isascii() and self.key.isprintable()) or " " in self.key:
            raise NoAnswer(
                "MIMELINE_API_KEY",
                found="a sign that no key has",
                expected="letters, digits and signs in one word",
                remedy="Copy the key anew.",
            )

    def answer(self, messages: Sequence[Mapping[str, str]]) -> str:
        """What the model says to messages of role and content. Raises NoAnswer."""
        body = {"model": self.model, "messages": list(messages), "temperature": 0}
        reply = self._posted(json.dumps(body).encode())
        try:
            content = json.loads(reply)["choices"][0]["message"]["content"]
        except (ValueError, LookupError, TypeError, RecursionError) as error:
            raise self._silent(
                f"an answer that is no chat completion: {_start(reply)}",
                "choices with a message",
                "See that the address is that of an OpenAI-compatible server, up to /v1.",
            ) from error
        if not isinstance(content, str):
            raise self._silent(
                "a message without text", "text", "Name another model: --language-model."
            )
        return content

    def _posted(self, body: bytes) -> bytes:
        headers = {"Content-Type": "application/json", "Accept": "application/json"}
        if self.key:
            headers["Authorization"] = f"Bearer {self.key}"
        address = f"{self.address.rstrip('/')}/chat/completions"
        request = urllib.request.Request(address, body, headers)
        try:
            with _OPENER.open(request, timeout=TIMEOUT_S) as reply:
                content = _read(reply, MOST_BYTES + 1)
        except HTTPError as error:
            with error:
                said = self._said(error)
            raise self._silent(
                f"{error.code} {error.reason}{f': {said}' if said else ''}",
                "an answer",
                _REMEDIES.get(error.code, "See what the server logs."),
            ) from error
        except (OSError, HTTPException, ValueError) as error:
            reason = error.reason if isinstance(error, URLError) else error
            raise self._silent(
                f"no server that answers ({reason})",
                f"one within {TIMEOUT_S:g} s",
                "Start it, or leave --endpoint out: simple sentences are read without one.",
            ) from error
        if len(content) > MOST_BYTES:
            raise self._silent(
                f"more than {MOST_BYTES // 10**6} MB", "a timeline", "Name another model."
            )
        return content

    def _said(self, error: HTTPError) -> str:
        """What a server says of its troubles, as far as it says it, without the key."""
        try:
            content = _read(error, PIECE)
        except (OSError, HTTPException, ValueError):
            return ""
        text = content.decode(errors="replace")
        return _start((text.replace(self.key, "…") if self.key else text).encode())

    def _silent(self, found: str, expected: str, remedy: str) -> NoAnswer:
        return NoAnswer(self.address, found=found, expected=expected, remedy=remedy)


_KEY = "Put the account's key into the environment: MIMELINE_API_KEY."
_REMEDIES = {
    401: _KEY,
    403: _KEY,
    404: "See that the address ends in /v1 and that the server has the model.",
    429: "The server has too much to do, or the account is used up: try again later.",
}


class _NoRedirect(urllib.request.HTTPRedirectHandler):
    """An answer from elsewhere is none: the key was meant for the server that was named."""

    def redirect_request(self, *_: Any) -> None:
        return None


_OPENER = urllib.request.build_opener(_NoRedirect)


def _fault(address: str) -> str | None:
    """What is wrong with an address, without any password that it holds."""
    try:
        parts = urlsplit(address)
        named = parts.scheme in ("http", "https") and parts.hostname and parts.port != 0
    except ValueError:
        return "an address that is none"
    if parts.username is not None or parts.password is not None or parts.query:
        return "an address with a name, a password or a query"
    plain = named and address.isascii() and address.isprintable() and " " not in address
    return None if plain and not parts.fragment else repr(address)


def _read(reply: HTTPResponse | HTTPError, most: int) -> bytes:
    """Up to `most` bytes of a reply. Raises TimeoutError where they drip in for too long."""
    content, until = bytearray(), time.monotonic() + TIMEOUT_S
    while len(content) < most and (piece := reply.read1(min(PIECE, most - len(content)))):
        content += piece
        if time.monotonic() > until:
            raise TimeoutError("it answers too slowly")
    return bytes(content)


def _start(content: bytes) -> str:
    text = " ".join(content.decode(errors="replace").split())
    return text if len(text) <= SHOWN else f"{text[:SHOWN]}…"
