from typing import TYPE_CHECKING

from mimeline.annotation.series import series
from mimeline.workflow import stage

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with stage(snakemake) as job:
    series(
        clips=job.input.clips,
        motions=job.input.motions,
        series=job.output.series,
        region=job.wildcards.region,
        **job.params.series,
    )
