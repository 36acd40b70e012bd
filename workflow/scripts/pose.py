from typing import TYPE_CHECKING

from mimeline.clips.pose import pose
from mimeline.workflow import stage

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with stage(snakemake) as job:
    pose(
        clips=job.input.clips,
        motion=job.input.motion,
        data=job.input.data,
        kept=job.output.clips,
        ledger=job.output.ledger,
        **job.params.pose,
        max_yaw_deg=job.params.max_yaw_deg,
    )
