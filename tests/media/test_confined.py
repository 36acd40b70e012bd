import os
import signal
import subprocess
import sys

import pytest

from mimeline.media.confined import MEMORY_MB, run_confined
from mimeline.media.limits import Limits

CHILD = """
import sys, time
with open(sys.argv[1], "w") as told:
    print("begun", file=told, flush=True)
    time.sleep(20)
    print("lived on", file=told)
"""
PARENT = """
import sys
from pathlib import Path
from mimeline.media.confined import run_confined
from mimeline.media.limits import Limits
child = [sys.executable, "-c", sys.argv[1], sys.argv[2]]
run_confined(child, Path("a.mp4"), Limits(), file_bytes=1000)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells a child of its parent's end")
@pytest.mark.parametrize("end", [signal.SIGTERM, signal.SIGKILL])
def test_a_child_ends_with_a_parent_that_is_killed(tmp_path, end):
    os.mkfifo(tmp_path / "told")
    command = [sys.executable, "-c", PARENT, CHILD, str(tmp_path / "told")]
    with subprocess.Popen(command) as parent, open(tmp_path / "told") as told:
        assert told.readline() == "begun\n"
        parent.send_signal(end)
        assert told.read() == ""  # closed by its death, not by its end


@pytest.mark.skipif(sys.platform == "darwin", reason="macOS does not bound the address space")
def test_a_child_gets_no_more_memory_than_its_rule_asks_for(tmp_path):
    code = f"bytearray({MEMORY_MB} * 1_000_000)"
    outcome = run_confined([sys.executable, "-c", code], tmp_path, Limits(), file_bytes=1000)
    assert outcome.code == 1 and "MemoryError" in outcome.complaint


def test_a_full_disk_is_told_as_such(tmp_path):
    code = "raise OSError(28, 'No space left on device')"
    with pytest.raises(OSError, match="No space left on device"):
        run_confined([sys.executable, "-c", code], tmp_path, Limits(), file_bytes=1000)
