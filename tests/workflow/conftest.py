"""Checkouts of their own in which the whole workflow runs.

Whole runs take the longest of all tests: those that the tests ask for go on beside the others from
the start. The tests that need none of them come first, then those of each run as it is over.
"""

import os
import signal
from collections.abc import Iterator
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

from .checkouts import CHECKOUT, PARTS, Workflow, copy_checkout
from .whole_runs import RUNS, STUDIES, Beside


def pytest_collection_modifyitems(items):
    items.sort(key=lambda item: max(map(RUNS.index, {*RUNS} & {*item.fixturenames}), default=-1))


@pytest.fixture(scope="session", autouse=True)
def beside(request) -> Iterator[Beside]:
    """The whole runs that tests ask for, begun before the first of these tests."""
    asked = {name for item in request.session.items for name in item.fixturenames}
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # as a shell's script starts with &: what
        signal.signal(signal.SIGINT, signal.default_int_handler)  # we start would not hear Ctrl-C
    runs = Beside(asked & {*RUNS})
    yield runs
    runs.close()


@pytest.fixture(scope="session")
def toy_run(beside) -> Workflow:
    """A checkout in which `snakemake all` has run on the tiny toy world."""
    return beside.get("toy_run")


@pytest.fixture(scope="session")
def studied_run(beside, toy_run) -> tuple[Path, str]:
    """The results of a finished run on which all STUDIES ran, and what these said."""
    return beside.get("studied_run")


@pytest.fixture(scope="session")
def clipless_run(beside) -> tuple[Path, str]:
    """The checkout of a run that lost every clip, and what the run said."""
    return beside.get("clipless_run")


@pytest.fixture(scope="session")
def killed_run(beside, toy_run) -> tuple[Path, Path]:
    """The results of a run that was stopped at random moments and resumed; those of one that was
    left alone."""
    return beside.get("killed_run")


@pytest.fixture(scope="session")
def livelink_run(beside, real_data) -> Path:
    """The results of the example of that name; so with those below."""
    return beside.get("livelink_run")


@pytest.fixture(scope="session")
def dreamtalk_run(beside, real_data) -> Path:
    return beside.get("dreamtalk_run")


@pytest.fixture(scope="session")
def pyfeat_run(beside, real_data) -> Path:
    return beside.get("pyfeat_run")


@pytest.fixture(scope="session")
def openface_run(beside, real_data) -> Path:
    return beside.get("openface_run")


@pytest.fixture(scope="session")
def metrical_tracker_run(beside) -> Path:
    return beside.get("metrical_tracker_run")


@pytest.fixture(scope="session")
def videos_run(beside, real_data) -> Path:
    return beside.get("videos_run")


@pytest.fixture(scope="session")
def celebvtext_run(beside, real_data) -> Path:
    return beside.get("celebvtext_run")


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
                settings = DAGSettings(targets={"all", *STUDIES}, forceall=True)
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
