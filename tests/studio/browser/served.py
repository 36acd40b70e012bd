"""A page of mimeline, served by the command that people type."""

import re
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

COMMAND = Path(sys.executable).with_name("mimeline")


class Served:
    """`mimeline <words>` as it runs; address: what it said to open.

    words: such as review --results results. file: what the page writes, the command's last word.
    port: 0 for any that is free.
    """

    def __init__(self, folder: Path, *words: object, file: Path, port: int = 0):
        command = [COMMAND, *words, file, "--no-browser", "--port", port]
        self._process = subprocess.Popen(
            list(map(str, command)),
            cwd=folder,
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
        )
        first = self._process.stdout.readline()
        found = re.search(r"http://127\.0\.0\.1:(\d+)/\S+", first)
        assert found, first + self._process.communicate()[0]
        self.file, self.address, self.port = file, found[0], int(found[1])

    def end(self) -> str:
        """End it as Ctrl-C does; what it said."""
        with suppress(ProcessLookupError):
            self._process.send_signal(signal.SIGINT)
        return self._process.communicate(timeout=20)[0]

    def kill(self) -> None:
        """End it as a crash does."""
        if self._process.poll() is None:
            self._process.kill()
            self._process.communicate()
