"""The workflow's jobs and their params, computed in this process without running anything."""

from pathlib import Path

from snakemake.api import SnakemakeApi
from snakemake.settings.types import (
    ConfigSettings,
    DAGSettings,
    OutputSettings,
    Quietness,
    ResourceSettings,
)

CHECKOUT = Path(__file__).parents[2]


def job_params(workdir: Path, config: dict) -> dict[tuple[str, tuple[str, ...]], dict]:
    """(rule, wildcard values) → params by name, of every job that a first run would need."""
    with SnakemakeApi(OutputSettings(quiet={Quietness.ALL})) as api:
        workflow = api.workflow(
            resource_settings=ResourceSettings(cores=1),
            config_settings=ConfigSettings(config=config),
            snakefile=CHECKOUT / "Snakefile",
            workdir=workdir,
        )
        workflow.dag(DAGSettings())
        inner = workflow._workflow
        inner.dag_settings = DAGSettings(forceall=True)
        inner._prepare_dag(forceall=True, ignore_incomplete=True, lock_warn_only=True, nolock=True)
        inner._build_dag()
        return {
            (job.rule.name, tuple(job.wildcards_dict.values())): dict(job.params.items())
            for job in inner.dag.jobs
        }
