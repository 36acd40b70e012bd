"""What a public address leads to is public, too: no server sends us to machines behind our door."""

import ipaddress
import socket
import sys
import urllib.request
from urllib.parse import urlsplit


def stay_out(origin: str) -> None:
    """Let this process connect to no private host, wherever redirects and pages send it.

    origin: the address that the user named; where it is private itself, or a proxy connects in our
    place, nothing is forbidden. There is no way back: it is for a child process.
    """
    if urllib.request.getproxies().keys() & {"http", "https", "all"}:
        return
    try:
        own = {there[4][0] for there in socket.getaddrinfo(urlsplit(origin).hostname, None)}
    except (OSError, ValueError):
        own = set()
    if not any(is_private(host) for host in own):
        sys.addaudithook(_refuse)


def is_private(host: str) -> bool:
    """Whether an IP address belongs to this machine, to its network, or to nobody."""
    there = ipaddress.ip_address(host.partition("%")[0])
    return not (getattr(there, "ipv4_mapped", None) or there).is_global


def _refuse(event: str, arguments: tuple) -> None:
    if event != "socket.connect" or not isinstance(arguments[1], tuple):
        return
    host = arguments[1][0]
    if is_private(host):
        raise OSError(f"the public address leads to a private one ({host})")
