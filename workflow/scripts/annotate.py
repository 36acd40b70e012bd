from typing import TYPE_CHECKING

from mimeline.annotation.annotate import annotate
from mimeline.workflow import by_region, stage

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with stage(snakemake) as job:
    annotate(
        clips=job.input.clips,
        motion=job.input.motion,
        clusters=by_region(job.input.clusters),
        labels=job.input.labels,
        intervals=job.output.intervals,
        frames=job.output.frames,
        **job.params.annotate,
    )
