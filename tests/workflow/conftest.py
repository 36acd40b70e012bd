"""A checkout of its own in which the whole workflow has run once on a tiny toy world."""

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import pytest
from snakemake.api import SnakemakeApi
from snakemake.settings.types import (
    ConfigSettings,
    DAGSettings,
    OutputSettings,
    Quietness,
    ResourceSettings,
)

CHECKOUT = Path(__file__).parents[2]
TINY = "tests/workflow/tiny.yaml"
PARTS = ("Snakefile", "workflow", "config", "profiles")
CODE = ("src", "resources")


@dataclass
class Workflow:
    """A checkout: snakemake runs in it as a user would run it.

    source: the package's folder, whose compiled kernels are kept beside it.
    """

    root: Path
    source: Path

    def run(self, *arguments: str, config: tuple[str, ...] = (TINY,)):
        """Run snakemake with the config files given; returns the finished process."""
        pipes = {"capture_output": True, "text": True, "timeout": 600}
        return subprocess.run(self._command(arguments, config), **self._place(), **pipes)

    def start(self, *arguments: str) -> subprocess.Popen:
        """Start snakemake on the tiny world in a process group of its own, and come back."""
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        command = self._command(arguments, (TINY,))
        return subprocess.Popen(command, **self._place(), **quiet, start_new_session=True)

    def _command(self, arguments: tuple[str, ...], config: tuple[str, ...]) -> list[str]:
        command = [sys.executable, "-m", "snakemake", "--cores", "2", *arguments]
        return command + (["--configfile", *(str(CHECKOUT / c) for c in config)] if config else [])

    def _place(self) -> dict:
        return {"cwd": self.root, "env": os.environ | {"PYTHONPATH": str(self.source)}}

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


@pytest.fixture(scope="session")
def toy_run(tmp_path_factory) -> Workflow:
    """A checkout in which `snakemake all` has run on the tiny toy world."""
    workflow = copy_checkout(tmp_path_factory.mktemp("checkout"), PARTS + CODE)
    done = workflow.run()
    assert done.returncode == 0, done.stdout + done.stderr
    return workflow


@pytest.fixture
def checkout(tmp_path) -> Workflow:
    """A checkout in which nothing has run; the code is that of this one."""
    return copy_checkout(tmp_path / "checkout", PARTS)


@pytest.fixture(scope="session")
def job_params(tmp_path_factory):
    """config → params by (rule, wildcard values) of all jobs, computed in this process."""
    workdir = tmp_path_factory.mktemp("dag")
    (workdir / "config").symlink_to(CHECKOUT / "config")

    def job_params(config: dict) -> dict[tuple[str, tuple[str, ...]], dict]:
        here = Path.cwd()
        try:
            with SnakemakeApi(OutputSettings(quiet={Quietness.ALL})) as api:
                workflow = api.workflow(
                    resource_settings=ResourceSettings(cores=1),
                    config_settings=ConfigSettings(config=config),
                    snakefile=CHECKOUT / "Snakefile",
                    workdir=workdir,
                )
                settings = DAGSettings(targets={"all", "sweep"}, forceall=True)
                workflow.dag(settings)
                inner = workflow._workflow  # the public interface prints, but does not give, jobs
                inner.dag_settings = settings
                inner._prepare_dag(forceall=True, ignore_incomplete=True, lock_warn_only=True)
                inner._build_dag()
                return {
                    (job.rule.name, tuple(job.wildcards_dict.values())): dict(job.params.items())
                    for job in inner.dag.jobs
                }
        finally:
            os.chdir(here)

    return job_params
