from typing import TYPE_CHECKING

from mimeline.clips.catalogue import catalogue
from mimeline.workflow import stage

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with stage(snakemake) as job:
    catalogue(
        data=job.input.data,
        clips=job.output.clips,
        ledger=job.output.ledger,
        **job.params.catalogue,
        cut_s=job.params.cut_s,
        tracker=job.params.tracker,
        limits=job.params.limits,
    )
