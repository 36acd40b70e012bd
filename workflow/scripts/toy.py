from typing import TYPE_CHECKING

from mimeline.toy import make
from mimeline.workflow import stage

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with stage(snakemake) as job:
    make(
        job.output.data,
        job.output.truth,
        **job.params.toy,
    )
