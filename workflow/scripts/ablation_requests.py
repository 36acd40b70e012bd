from typing import TYPE_CHECKING

from mimeline.evaluation.requests import requests
from mimeline.evaluation.variants import ASKED
from mimeline.workflow import by_name, stage

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with stage(snakemake) as job:
    requests(
        frames=job.input.frames,
        split=job.input.split,
        asked=by_name(ASKED, job.output.asked),
        unseen=job.params.unseen,
        choice_seed=job.params.choice_seed,
        timelines=job.params.timelines,
        length=job.params.length,
        seed=job.params.seed,
    )
