from typing import TYPE_CHECKING

from mimeline.reporting.experiments import experiments
from mimeline.workflow import by_region, stage

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with stage(snakemake) as job:
    experiments(
        found=by_region(job.input.found),
        left_out=by_region(job.input.left_out),
        annotation=job.input.annotation,
        paper=job.input.paper,
        page=job.output.page,
        summary=job.output.summary,
        configured=job.params.configured,
        side=job.params.side,
        resamples=job.params.resamples,
        seed=job.params.seed,
        address=snakemake.output.page,
    )
