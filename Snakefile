import time
from pathlib import Path

from snakemake.utils import min_version

from mimeline.evaluation.variants import ASKED, MADE, variants
from mimeline.run import remember
from mimeline.vocabulary import SERIES_REGIONS
from mimeline.workflow import (
    chosen,
    code_digest,
    face_of_takes,
    limits_of_videos,
    listing,
    rate_of_clips,
    resource_table,
    settle_config,
    tracker_of_takes,
)

min_version("9.20")


configfile: "config/config.yaml"


config.update(settle_config(config))


pathvars:
    logs="<results>/logs",
    benchmarks="<results>/benchmarks",


container: "docker://python:3.12-slim"


report: "workflow/report/workflow.rst"


wildcard_constraints:
    shard=r"\d+",
    region="|".join(SERIES_REGIONS),
    model="|".join(config["train"]["models"]),


include: "workflow/rules/data.smk"
include: "workflow/rules/annotation.smk"
include: "workflow/rules/learning.smk"
include: "workflow/rules/ablations.smk"
include: "workflow/rules/report.smk"


rule all:
    default_target: True
    input:
        "<results>/report/index.html",


STARTED = time.time()


onstart:
    remember(
        Path(workflow.pathvars.apply("<results>")),
        config,
        files=workflow.config_settings.configfiles,
        given=workflow.config_settings.config_args or [],
    )


onsuccess:
    if (
        page := Path(workflow.pathvars.apply("<results>/report/index.html"))
    ).exists() and page.stat().st_mtime > STARTED:
        print(f"mimeline: the report is {page}", flush=True)
