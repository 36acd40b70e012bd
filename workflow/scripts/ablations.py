from typing import TYPE_CHECKING

from mimeline.evaluation.variants import ASKED, MADE
from mimeline.reporting.ablations import ablations
from mimeline.workflow import by_name, stage

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with stage(snakemake) as job:
    trained = [tuple(own) for own in job.params.trained]
    made, found = ([(*own, name) for own in trained for name in sets] for sets in (MADE, ASKED))
    ablations(
        asked=by_name(ASKED, job.input.asked),
        made=by_name(made, job.input.made),
        found=by_name(found, job.input.found),
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
