"""A program run on a file that nobody vouches for: bounded in time, memory and what it writes."""

import resource
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from mimeline.media.limits import Limits, Refused

TOLD_BYTES = 8_000  # of what a program complains; the rest repeats it


@dataclass(frozen=True)
class Outcome:
    """How a program ended: its exit code (negative: a signal), what it said and complained."""

    code: int
    said: bytes
    complaint: str


def run_confined(
    arguments: Sequence[str],
    source: Path,
    limits: Limits,
    *,
    memory_bytes: int,
    stdin: BinaryIO | int = subprocess.DEVNULL,
) -> Outcome:
    """Run a program on source; it ends with us or at limits.timeout_s, whichever is first.

    memory_bytes: address space that it may use; none of its files outgrows limits.max_bytes.
    It stays in our process group, so that an interrupt reaches both.
    Raises Refused (timed_out).
    """

    def confine() -> None:
        _lower(resource.RLIMIT_AS, memory_bytes)
        _lower(resource.RLIMIT_FSIZE, limits.max_bytes)
        _lower(resource.RLIMIT_CORE, 0)
        _lower(resource.RLIMIT_CPU, int(2 * limits.timeout_s) + 1)  # should we be killed before it

    with tempfile.TemporaryFile() as said, tempfile.TemporaryFile() as complaints:
        try:
            done = subprocess.run(
                list(arguments),
                stdin=stdin,
                stdout=said,
                stderr=complaints,
                timeout=limits.timeout_s,
                preexec_fn=confine,
            )
        except subprocess.TimeoutExpired:
            raise Refused(
                source,
                rule="timed_out",
                value=limits.timeout_s,
                limit=limits.timeout_s,
                unit="s",
                found=f"more than {limits.timeout_s:g} s of work",
                expected="to be done within that time",
                remedy="Look whether the file plays; if it does, raise the time limit.",
            ) from None
        said.seek(0)
        complaints.seek(max(0, complaints.seek(0, 2) - TOLD_BYTES))
        return Outcome(done.returncode, said.read(), complaints.read().decode("utf-8", "replace"))


def _lower(kind: int, limit: int) -> None:
    """Not every system bounds the address space; the time limit holds on all."""
    if kind == resource.RLIMIT_AS and sys.platform == "darwin":
        return
    hard = resource.getrlimit(kind)[1]
    limit = limit if hard == resource.RLIM_INFINITY else min(limit, hard)
    resource.setrlimit(kind, (limit, limit))
