from typing import TYPE_CHECKING

from mimeline.evaluation.labelling import evaluate_labelling
from mimeline.workflow import by_region, stage

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with stage(snakemake) as job:
    evaluate_labelling(
        clips=job.input.clips,
        ledgers=job.input.ledgers,
        clusters=by_region(job.input.clusters),
        proposed=job.input.proposed,
        exemplars=job.input.exemplars,
        truth=job.input.truth or None,
        metrics=job.output.metrics,
        looks=job.params.looks,
        seed=job.params.seed,
    )
