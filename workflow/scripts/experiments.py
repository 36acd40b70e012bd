from typing import TYPE_CHECKING

from mimeline.reporting.experiments import experiments
from mimeline.workflow import by_region, stage

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with stage(snakemake) as job:
    experiments(
        found=by_region(job.input.found),
        annotation=job.input.annotation,
        paper=job.input.paper,
        page=job.output.page,
        summary=job.output.summary,
        n_clusters=job.params.n_clusters,
        beta=job.params.beta,
        claspy=job.params.claspy,
        resamples=job.params.resamples,
        seed=job.params.seed,
        address=snakemake.output.page,
    )
