from typing import TYPE_CHECKING

from mimeline.dataset.split import split
from mimeline.workflow import stage

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with stage(snakemake) as job:
    split(
        clips=job.input.clips,
        motions=job.input.motions,
        fingerprints=job.input.fingerprints,
        split=job.output.split,
        duplicates=job.output.duplicates,
        statistics_table=job.output.statistics,
        ledger=job.output.ledger,
        **job.params.split,
    )
