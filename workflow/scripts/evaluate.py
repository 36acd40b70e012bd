from typing import TYPE_CHECKING

from mimeline.evaluation.timeline import evaluate_timeline
from mimeline.workflow import by_region, stage

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with stage(snakemake) as job:
    evaluate_timeline(
        checkpoint=job.input.checkpoint,
        motions=job.input.motions,
        frames=job.input.frames,
        split=job.input.split,
        segment_models=by_region(job.input.models),
        labels=job.input.labels,
        metrics=job.output.metrics,
        generated=job.output.generated,
        annotate=job.params.annotate,
        resamples=job.params.resamples,
        options=job.params.options,
        threads=job.threads,
    )
