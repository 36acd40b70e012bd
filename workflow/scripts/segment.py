from typing import TYPE_CHECKING

from mimeline.annotation.segment import segment
from mimeline.workflow import stage

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with stage(snakemake) as job:
    segment(
        series=job.input.series,
        model=job.output.model,
        clusters=job.output.clusters,
        region=job.wildcards.region,
        side=job.params.side,
        null_length=job.params.null_length,
        null_value=job.params.null_value,
        **job.params.segment,
    )
