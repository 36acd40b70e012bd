from typing import TYPE_CHECKING

from mimeline.annotation.labels import label
from mimeline.workflow import by_region, stage

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with stage(snakemake) as job:
    label(
        series=by_region(job.input.series),
        clusters=by_region(job.input.clusters),
        models=by_region(job.input.models),
        proposals=job.input.proposals,
        labels=job.output.labels,
        names=job.output.names,
        exemplars=job.output.exemplars,
        side=job.params.side,
        **job.params.label,
    )
