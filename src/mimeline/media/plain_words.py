"""What goes wrong between us and a server, said in plain words."""

import re

NO_HOST = "no such host, or no network"
LATER = "a host whose name cannot be looked up now"
SILENT = "a server that stayed silent (fetch.stall_s)"
CLOSED = "a server that broke off the connection"
NO_WAY = "no way to the server: its network or ours is down"
SAYINGS = {  # what systems and libraries say → what we say
    "Connection refused": "a server that refused the connection",
    "Temporary failure in name resolution": LATER,
    "Name or service not known": NO_HOST,
    "nodename nor servname provided": NO_HOST,
    "No address associated with hostname": NO_HOST,
    "Name does not resolve": NO_HOST,
    "timed out": SILENT,
    "Remote end closed connection": CLOSED,
    "Connection reset": CLOSED,
    "Connection aborted": CLOSED,
    "Broken pipe": CLOSED,
    "Network is unreachable": NO_WAY,
    "No route to host": NO_WAY,
    "CERTIFICATE_VERIFY_FAILED": "a certificate that cannot be trusted",
    "unknown url type": "an address that is neither http nor https",
}
LACKING = re.compile(r"(\d+) bytes read, (\d+) more expected")
STATUS = re.compile(r"HTTP Error (\d{3})(?:: ([\w -]+))?")
TOO_SHORT = re.compile(r"Downloaded (\d+) bytes, expected (\d+) bytes")


def in_plain_words(said: str) -> str | None:
    """What a library says of the network, in our words; None where we know none."""
    if lacking := LACKING.search(said):
        came, more = map(int, lacking.groups())
        return broke_off(came, came + more)
    if short := TOO_SHORT.search(said):
        return broke_off(*map(int, short.groups()))
    if status := STATUS.search(said):
        return answered(int(status[1]), status[2])
    return next((ours for theirs, ours in SAYINGS.items() if theirs in said), None)


def broke_off(came: int, whole: int) -> str:
    """Of a body of `whole` bytes, `came` came."""
    return f"a server that broke off after {came} of {whole} bytes"


def answered(status: int, reason: str | None) -> str:
    """What a server answered instead of giving a video."""
    return f"the answer {status} ({reason})" if reason else f"the answer {status}"
