"""One task in several processes of this machine, which end together."""

import logging
import logging.handlers
import os
import pickle
import subprocess
import sys
import tempfile
import threading
import traceback
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, Pipe, wait
from pathlib import Path
from typing import Any, TypeVar

import torch

from mimeline.errors import MimelineError

Result = TypeVar("Result")

PACKAGE = "mimeline"
GRACE_S = 2.0  # for a process that was killed to be found dead, once another misses it


class LostProcess(MimelineError):
    """A process of a training ended before its work was done."""


@dataclass(frozen=True)
class Worker:
    """A process that was started, and the line to it."""

    process: subprocess.Popen
    line: Connection

    def end(self) -> None:
        self.process.kill()
        self.process.wait()
        self.line.close()


def together(processes: int, backend: str, task: Callable[..., Result], *args: Any) -> Result:
    """What task(*args) gives in the first of so many processes, joined by torch.distributed.

    One process is this one. Several are new ones, which find the task by its name, whatever the
    main program is. They end with this one and with each other: when one fails, this raises what
    it raised, or LostProcess where it was killed. What the first one logs is logged here. They
    share the threads of this one. backend: of torch.distributed, gloo or nccl.
    """
    if processes == 1:
        return task(*args)
    with tempfile.TemporaryDirectory() as folder:
        group = {
            "backend": backend,
            "init_method": f"file://{Path(folder, 'meeting')}",
            "world_size": processes,
        }
        workers: list[Worker] = []
        try:
            for rank in range(processes):
                workers.append(_start(rank, processes))
            for rank, worker in enumerate(workers):
                with suppress(OSError):  # it is dead already, which `_result` tells
                    worker.line.send_bytes(pickle.dumps((group | {"rank": rank}, task, args)))
            return _result(workers)
        finally:
            for worker in workers:
                worker.end()


def _start(rank: int, processes: int) -> Worker:
    ours, theirs = Pipe()
    numbers = {"RANK": rank, "WORLD_SIZE": processes}
    numbers |= {f"LOCAL_{name}": number for name, number in numbers.items()}
    numbers["OMP_NUM_THREADS"] = max(1, torch.get_num_threads() // processes)
    environment = os.environ | {name: str(number) for name, number in numbers.items()}
    environment["PYTHONPATH"] = os.pathsep.join(path for path in sys.path if path)
    with theirs:
        process = subprocess.Popen(
            [sys.executable, "-m", __spec__.name, str(theirs.fileno())],
            env=environment,
            stdin=subprocess.DEVNULL,
            pass_fds=[theirs.fileno()],
            start_new_session=True,  # Ctrl-C is for this process, which ends the others
        )
    return Worker(process, ours)


def _result(workers: list[Worker]) -> Any:
    """Wait until all are done; what the first one gave."""
    results: dict[int, Any] = {}
    while len(results) < len(workers):
        waiting = {w.line: rank for rank, w in enumerate(workers) if rank not in results}
        for line in wait(list(waiting)):
            rank = waiting[line]
            try:
                kind, value = pickle.loads(line.recv_bytes())
            except (EOFError, OSError):
                raise _lost(rank, workers) from None
            if kind == "log":
                logging.getLogger(value.name).handle(value)
            elif kind == "result":
                results[rank] = value
            else:
                error = _remade(*value)
                if not isinstance(error, MimelineError):
                    _look_for_the_lost(workers)
                raise error
    return results[0]


def _look_for_the_lost(workers: list[Worker]) -> None:
    """Raise LostProcess where a process was killed: others then fail at talking to it."""
    for rank, worker in enumerate(workers):
        with suppress(subprocess.TimeoutExpired):
            if worker.process.wait(GRACE_S) < 0:
                raise _lost(rank, workers)


def _lost(rank: int, workers: list[Worker]) -> LostProcess:
    status = workers[rank].process.wait()
    how = f"signal {-status}" if status < 0 else f"exit status {status}"
    return LostProcess(
        f"process {rank + 1} of {len(workers)} of the training",
        found=f"it ended with {how}",
        expected="its share of the work",
        remedy="It may have lacked memory: lower batch or train.hardware.processes, then type the "
        "same command.",
    )


def _remade(kind: type[Exception], args: tuple, attributes: dict[str, Any]) -> Exception:
    """The exception again; not every one can be made from its arguments alone."""
    error = kind.__new__(kind)
    error.args = args
    error.__dict__.update(attributes)
    return error


class _Messages(logging.handlers.QueueHandler):
    """Sends log records over the line to the parent."""

    def enqueue(self, record: logging.LogRecord) -> None:
        self.queue.send_bytes(pickle.dumps(("log", record)))


def _end_with_parent(line: Connection) -> None:
    """Nothing more comes over the line but its end, when the parent is gone."""
    try:
        line.recv_bytes()
    except (EOFError, OSError):
        os._exit(1)


def _work(line: Connection) -> None:
    """A new process's own part."""
    group, task, args = pickle.loads(line.recv_bytes())
    threading.Thread(target=_end_with_parent, args=(line,), daemon=True).start()
    logger = logging.getLogger(PACKAGE)
    logger.propagate = False
    logger.addHandler(logging.NullHandler() if group["rank"] else _Messages(line))
    logger.setLevel(logging.INFO)
    try:
        if sys.platform == "linux":
            os.environ.setdefault("GLOO_SOCKET_IFNAME", "lo")  # else it asks the host's name
        torch.distributed.init_process_group(**group)
        result = task(*args)
        message = "result", None if group["rank"] else result
    except Exception as error:
        if not isinstance(error, MimelineError):
            error.add_note(traceback.format_exc())
        message = "error", (type(error), error.args, vars(error))
    line.send_bytes(pickle.dumps(message))


if __name__ == "__main__":
    _work(Connection(int(sys.argv[1])))
