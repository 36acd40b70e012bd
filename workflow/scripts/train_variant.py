from typing import TYPE_CHECKING

from mimeline.training.state import finished
from mimeline.training.train import train
from mimeline.workflow import stage

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with stage(snakemake) as job:
    train(
        model="timeline",
        motions=job.input.motions,
        frames=job.input.frames,
        clips=job.input.clips,
        origins=job.input.origins,
        split=job.input.split,
        statistics=job.input.statistics,
        checkpoint=job.output.checkpoint,
        options=job.params.options,
        hardware=job.params.hardware,
        state=job.params.state,
        code=job.params.code,
        threads=job.threads,
    )
finished(job.params.state)
