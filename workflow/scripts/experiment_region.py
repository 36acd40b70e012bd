from typing import TYPE_CHECKING

from mimeline.evaluation.experiments import experiments
from mimeline.workflow import stage

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with stage(snakemake) as job:
    experiments(
        clips=job.input.clips,
        ledgers=job.input.ledgers,
        motions=job.input.motions,
        units=job.input.units,
        rules=job.input.rules,
        truth=job.input.truth or None,
        found=job.output.found,
        left_out=job.output.left_out,
        region=job.wildcards.region,
        side=job.params.side,
        n_clusters=job.params.n_clusters,
        betas=job.params.betas,
        null_length=job.params.null_length,
        null_value=job.params.null_value,
        configured=job.params.segment,
        **job.params.experiments,
    )
