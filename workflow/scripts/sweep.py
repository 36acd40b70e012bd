from typing import TYPE_CHECKING

from mimeline.reporting.sweep import sweep
from mimeline.workflow import by_region, stage

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with stage(snakemake) as job:
    sweep(
        page=job.output.page,
        scores=by_region(job.input.scores),
        n_clusters=job.params.n_clusters,
        beta=job.params.beta,
        address=snakemake.output.page,
    )
