from typing import TYPE_CHECKING

from mimeline.evaluation.variants import SETS
from mimeline.reporting.ablations import ablations
from mimeline.workflow import stage

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with stage(snakemake) as job:
    runs = [tuple(run) for run in job.params.runs]
    ablations(
        asked=dict(zip(SETS, job.input.asked, strict=True)),
        made=dict(zip(runs, job.input.made, strict=True)),
        found=dict(zip(runs, job.input.found, strict=True)),
        motions=job.input.motions,
        frames=job.input.frames,
        clips=job.input.clips,
        split=job.input.split,
        paper=job.input.paper,
        page=job.output.page,
        summary=job.output.summary,
        configured=job.params.configured,
        wanted=job.params.wanted,
        side=job.params.side,
        unseen=job.params.unseen,
        choice_seed=job.params.choice_seed,
        resamples=job.params.resamples,
        seed=job.params.seed,
        address=snakemake.output.page,
    )
