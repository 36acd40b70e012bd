from typing import TYPE_CHECKING

from mimeline.evaluation.variant_motion import generated
from mimeline.evaluation.variants import ASKED, MADE
from mimeline.workflow import by_name, by_region, stage

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with stage(snakemake) as job:
    generated(
        checkpoint=job.input.checkpoint,
        asked=by_name(ASKED, job.input.asked),
        motions=job.input.motions,
        segment_models=by_region(job.input.models),
        labels=job.input.labels,
        made=by_name(MADE, job.output.made),
        found=by_name(ASKED, job.output.found),
        annotate=job.params.annotate,
        sampling=job.params.sampling,
        seed=int(job.wildcards.seed),
        threads=job.threads,
    )
