from typing import TYPE_CHECKING

from mimeline.annotation.exemplars import exemplars
from mimeline.workflow import by_region, stage

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with stage(snakemake) as job:
    exemplars(
        series=by_region(job.input.series),
        clusters=by_region(job.input.clusters),
        models=by_region(job.input.models),
        rules=job.input.rules,
        proposed=job.output.proposed,
        names=job.output.names,
        exemplars=job.output.exemplars,
        side=job.params.side,
        n_random=job.params.n_random,
        seed=job.params.seed,
    )
