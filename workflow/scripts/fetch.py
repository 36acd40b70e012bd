from typing import TYPE_CHECKING

from mimeline.clips.fetch import fetch
from mimeline.workflow import stage

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with stage(snakemake) as job:
    fetch(
        clips=job.input.clips,
        data=job.input.data,
        kept=job.output.clips,
        times=job.output.times,
        fingerprints=job.output.fingerprints,
        ledger=job.output.ledger,
        media=job.params.media,
        sources=job.params.sources,
        recipe=job.params.recipe,
        **job.params.fetch,
    )
