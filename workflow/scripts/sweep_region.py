from typing import TYPE_CHECKING

from mimeline.evaluation.sweep import sweep
from mimeline.workflow import stage

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with stage(snakemake) as job:
    sweep(
        clips=job.input.clips,
        ledgers=job.input.ledgers,
        series=job.input.series,
        truth=job.input.truth or None,
        scores=job.output.scores,
        region=job.wildcards.region,
        side=job.params.side,
        n_clusters=job.params.sweep["n_clusters"],
        betas=job.params.sweep["beta"],
        seeds=job.params.sweep["seeds"],
        null_length=job.params.null_length,
        null_value=job.params.null_value,
        configured=job.params.segment,
    )
