from typing import TYPE_CHECKING

from mimeline.evaluation.annotation import evaluate_annotation
from mimeline.workflow import by_region, stage

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with stage(snakemake) as job:
    evaluate_annotation(
        clips=job.input.clips,
        ledgers=job.input.ledgers,
        motions=job.input.motions,
        frames=job.input.frames,
        series=by_region(job.input.series),
        clusters=by_region(job.input.clusters),
        rules=job.input.rules,
        truth=job.input.truth or None,
        metrics=job.output.metrics,
        confusion=job.output.confusion,
        side=job.params.side,
        annotate=job.params.annotate,
        gmm_components=job.params.gmm_components,
        overlap=job.params.overlap,
        resamples=job.params.resamples,
        seed=job.params.seed,
    )
