"""A program run on a file that nobody vouches for: bounded in time, memory and what it writes."""

import ctypes
import errno
import os
import resource
import signal
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from mimeline.media.limits import Limits, Refused

MEMORY_MB = 5000  # an 8K film of ten bits, decoded and encoded, takes 3900
TOLD_BYTES = 8_000  # of what a program complains; the rest repeats it
FULL = "No space left on device"
DIES_WITH_PARENT = 1  # PR_SET_PDEATHSIG of prctl(2)
# Loaded here and not in the child, where after the fork hardly anything may be called.
LIBC = ctypes.CDLL(None) if sys.platform == "linux" else None


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
    file_bytes: int,
    stdin: BinaryIO | int = subprocess.DEVNULL,
) -> Outcome:
    """Run a program on source; it ends at limits.timeout_s, or with us.

    file_bytes: no file that it writes outgrows this. Its address space is at most MEMORY_MB.
    It stays in our process group, so that an interrupt reaches both. Where we are killed it is
    killed too, on Linux; elsewhere it lives on until it is done or its time is over.
    Raises Refused (timed_out), OSError if the disk is full.
    """
    parent = os.getpid()

    def confine() -> None:
        if LIBC is not None:
            LIBC.prctl(DIES_WITH_PARENT, signal.SIGKILL)
            if os.getppid() != parent:  # we were killed before it was said
                os._exit(1)
        _lower(resource.RLIMIT_AS, MEMORY_MB * 1_000_000)
        _lower(resource.RLIMIT_FSIZE, file_bytes)
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
                remedy="Look whether the file plays; if it does, raise fetch.timeout_s.",
            ) from None
        said.seek(0)
        complaints.seek(max(0, complaints.seek(0, 2) - TOLD_BYTES))
        complaint = complaints.read().decode("utf-8", "replace")
        if FULL in complaint:
            raise OSError(errno.ENOSPC, FULL)
        return Outcome(done.returncode, said.read(), complaint)


def _lower(kind: int, limit: int) -> None:
    """Not every system bounds the address space; the time limit holds on all."""
    if kind == resource.RLIMIT_AS and sys.platform == "darwin":
        return
    hard = resource.getrlimit(kind)[1]
    limit = limit if hard == resource.RLIM_INFINITY else min(limit, hard)
    resource.setrlimit(kind, (limit, limit))
