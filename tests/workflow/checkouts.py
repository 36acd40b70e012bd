"""A checkout in which snakemake runs as a user would run it."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterable
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

CHECKOUT = Path(__file__).parents[2]
TINY = "tests/workflow/tiny.yaml"
PARTS = ("Snakefile", "workflow", "config", "profiles")
CODE = ("src", "resources")
# Runs go on beside tests that change the environment: none of theirs comes into a run.
ENVIRONMENT = dict(os.environ)


@dataclass
class Workflow:
    """A checkout: snakemake runs in it as a user would run it.

    source: the package's folder, whose compiled kernels are kept beside it. cores: of each run.
    running: the processes of all checkouts.
    """

    root: Path
    source: Path
    cores: int = 2
    running: ClassVar[set[subprocess.Popen]] = set()

    def run(self, *arguments: str, config: tuple[str, ...] = (TINY,)):
        """Run snakemake with the config files given; returns the finished process."""
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        with self._started(arguments, config, pipes) as process:
            told, complained = process.communicate(timeout=600)
        return subprocess.CompletedProcess(process.args, process.returncode, told, complained)

    @contextmanager
    def start(self, *arguments: str):
        """Start snakemake on the tiny world in a process group of its own; killed at the end."""
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        with self._started(arguments, (TINY,), quiet) as process:
            yield process

    @contextmanager
    def _started(self, arguments: tuple[str, ...], config: tuple[str, ...], pipes: dict):
        command = self._command(arguments, config)
        process = subprocess.Popen(command, **self._place(), **pipes, start_new_session=True)
        self.running.add(process)
        try:
            yield process
        finally:
            kill(process)
            self.running.discard(process)

    def _command(self, arguments: tuple[str, ...], config: tuple[str, ...]) -> list[str]:
        command = [sys.executable, "-m", "snakemake", "--cores", str(self.cores), *arguments]
        return command + (["--configfile", *(str(CHECKOUT / c) for c in config)] if config else [])

    def _place(self) -> dict:
        return {"cwd": self.root, "env": ENVIRONMENT | {"PYTHONPATH": str(self.source)}}

    def would_rerun(self, *config: str) -> set[str]:
        """The rules that a dry run names, with these config files after the tiny one."""
        done = self.run("-n", config=(TINY, *config))
        text = done.stdout + done.stderr
        assert done.returncode == 0, text
        stats = re.search(r"^job +count\n[- ]+\n(.*?)^total", text, re.M | re.S)
        rules = {line.split()[0] for line in stats[1].splitlines()} if stats else set()
        return rules - {"all"}

    def would_rerun_each(self, configs: Iterable[str]) -> list[set[str]]:
        """For each config file after the tiny one, the rules of a dry run; one process for all."""
        script = str(Path(__file__).with_name("dry_runs.py"))
        files = json.dumps([[str(CHECKOUT / TINY), config] for config in configs])
        command = [sys.executable, script, files]
        done = subprocess.run(command, **self._place(), capture_output=True, text=True, timeout=600)
        assert done.returncode == 0, done.stdout + done.stderr
        return [set(json.loads(line)) - {"all"} for line in done.stdout.splitlines()]


def copy_checkout(root: Path, parts: tuple[str, ...]) -> Workflow:
    """Copy what the workflow needs; a change in the copy touches nothing else."""
    root.mkdir(exist_ok=True)
    for name in parts:
        source = CHECKOUT / name
        if source.is_dir():
            # with what is compiled, but not what another process is writing just now
            ignore = shutil.ignore_patterns("*.pyc.*", "*.tmp.*")
            shutil.copytree(source, root / name, ignore=ignore)
        else:
            shutil.copy2(source, root / name)
    return Workflow(root, (root if "src" in parts else CHECKOUT) / "src")


def kill(process: subprocess.Popen) -> None:
    """End a process and all that it started."""
    if process.poll() is None:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
