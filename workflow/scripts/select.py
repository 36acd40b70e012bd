from typing import TYPE_CHECKING

from mimeline.clips.select import select
from mimeline.workflow import stage

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with stage(snakemake) as job:
    select(
        clips=job.input.clips,
        kept=job.output.clips,
        ledger=job.output.ledger,
        catalogue=job.input.catalogue,
        **job.params.select,
    )
