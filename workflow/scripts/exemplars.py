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
        exemplars=job.output.exemplars,
        profiles=job.output.profiles,
        side=job.params.side,
        n_random=job.params.n_random,
        n_further=job.params.n_further,
        seed=job.params.seed,
    )
