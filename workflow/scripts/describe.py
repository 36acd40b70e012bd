from typing import TYPE_CHECKING

from mimeline.clips.description.describe import describe
from mimeline.workflow import stage

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with stage(snakemake) as job:
    describe(
        clips=job.input.clips,
        intervals=job.input.intervals,
        descriptions=job.output.descriptions,
        attributes=job.output.attributes,
        weights=job.output.weights,
        **job.params.describe,
    )
