from typing import TYPE_CHECKING

from mimeline.reporting.report import report
from mimeline.workflow import by_region, stage

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with stage(snakemake) as job:
    report(
        page=job.output.page,
        ledgers=job.input.ledgers,
        catalogue=job.input.catalogue,
        data=job.input.data,
        fetched=job.input.fetched,
        clips=job.input.clips,
        motions=job.input.motions,
        origins=job.input.origins,
        series=by_region(job.input.series),
        clusters=by_region(job.input.clusters),
        labels=job.input.labels,
        exemplars=job.input.exemplars,
        profiles=job.input.profiles,
        intervals=job.input.intervals,
        frames=job.input.frames,
        split=job.input.split,
        duplicates=job.input.duplicates,
        descriptions=job.input.descriptions,
        attributes=job.input.attributes,
        weights=job.input.weights,
        statistics=job.input.statistics,
        annotation_metrics=job.input.annotation_metrics,
        confusion=job.input.confusion,
        labelling=job.input.labelling,
        models=job.params.models,
        checkpoints=job.input.checkpoints,
        metrics=job.input.metrics,
        generated=job.input.generated,
        truth=job.input.truth or None,
        face=job.input.face or None,
        annotate=job.params.annotate,
        overlap=job.params.overlap,
        side=job.params.side,
        sources=job.params.sources,
        balance=job.params.balance,
        options=job.params.report,
    )
