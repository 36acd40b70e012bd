"""Which rules dry runs name, many of them in one process: the rules of each, as a line of JSON.

The only argument is JSON: for each dry run, its config files.
"""

import json
import sys
from pathlib import Path

from snakemake.api import SnakemakeApi
from snakemake.settings.types import (
    ConfigSettings,
    DAGSettings,
    OutputSettings,
    Quietness,
    ResourceSettings,
)


def would_run(configfiles: list[str]) -> set[str]:
    """The rules that have something to do in the working folder."""
    with SnakemakeApi(OutputSettings(quiet={Quietness.ALL})) as api:
        workflow = api.workflow(
            resource_settings=ResourceSettings(cores=2),
            config_settings=ConfigSettings(configfiles=[Path(file) for file in configfiles]),
            snakefile=Path("Snakefile"),
        )
        settings = DAGSettings()
        workflow.dag(settings)
        inner = workflow._workflow  # the public interface prints, but does not give, jobs
        inner.dag_settings = settings
        inner._prepare_dag(forceall=False, ignore_incomplete=False, lock_warn_only=True)
        inner._build_dag()
        return {job.rule.name for job in inner.dag.needrun_jobs()}


if __name__ == "__main__":
    for configfiles in json.loads(sys.argv[1]):
        print(json.dumps(sorted(would_run(configfiles))))
