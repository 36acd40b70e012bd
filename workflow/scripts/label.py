from typing import TYPE_CHECKING

from mimeline.annotation.labels import label
from mimeline.workflow import by_region, stage

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with stage(snakemake) as job:
    label(
        proposed=job.input.proposed,
        clusters=by_region(job.input.clusters),
        models=by_region(job.input.models),
        labels=job.output.labels,
        names=job.output.names,
        file=job.params.file,
        min_agreement=job.params.min_agreement,
    )
