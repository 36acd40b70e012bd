from typing import TYPE_CHECKING

from mimeline.tracking.ingest import ingest
from mimeline.workflow import stage

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with stage(snakemake) as job:
    ingest(
        clips=job.input.clips,
        data=job.input.data,
        motion=job.output.motion,
        coefficients=job.output.coefficients,
        origins=job.output.origins,
        kept=job.output.clips,
        ledger=job.output.ledger,
        **job.params.ingest,
        mirrored=job.params.mirrored,
        bad_values=job.params.bad_values,
        max_missing=job.params.max_missing,
        max_loss=job.params.max_loss,
        max_reprojection=job.params.max_reprojection,
    )
