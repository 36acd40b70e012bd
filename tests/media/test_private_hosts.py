import os
import socket
import subprocess
import sys
import threading

import pytest

from mimeline.media.private_hosts import is_private

CHILD = """
import socket, sys
from mimeline.media.private_hosts import stay_out
stay_out(sys.argv[1])
socket.create_connection(("127.0.0.1", int(sys.argv[2])), timeout=5).close()
"""


@pytest.fixture(scope="module")
def port():
    with socket.create_server(("127.0.0.1", 0)) as server:
        threading.Thread(target=lambda: [server.accept() for _ in range(9)], daemon=True).start()
        yield server.getsockname()[1]


@pytest.mark.parametrize(
    ("origin", "proxy", "let_through"),
    [
        ("http://93.184.215.14/film.mp4", None, False),
        ("http://[2606:2800:220:1::1]/", None, False),
        ("http://127.0.0.1:1/film.mp4", None, True),
        ("http://93.184.215.14/film.mp4", "http://127.0.0.1:9", True),
    ],
)
def test_a_public_address_leads_to_no_private_host(port, origin, proxy, let_through):
    bare = {name: text for name, text in os.environ.items() if "proxy" not in name.lower()}
    environment = bare | ({"http_proxy": proxy} if proxy else {})
    command = [sys.executable, "-c", CHILD, origin, str(port)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert (done.returncode == 0) == let_through
    assert let_through or "leads to a private one (127.0.0.1)" in done.stderr


@pytest.mark.parametrize(
    ("host", "private"),
    [
        ("10.1.2.3", True),
        ("169.254.169.254", True),
        ("::1", True),
        ("::ffff:127.0.0.1", True),
        ("fe80::1%eth0", True),
        ("0.0.0.0", True),
        ("8.8.8.8", False),
        ("2001:4860:4860::8888", False),
    ],
)
def test_hosts_of_this_network_are_told_from_others(host, private):
    assert is_private(host) == private
