rule report:
    input:
        ledgers=[*LEDGERS, "<results>/split/ledger.parquet"],
        catalogue=expand("<results>/catalogue/{shard}/clips.parquet", shard=SHARDS),
        data=DATA,
        fetched=expand("<results>/fetch/{shard}/clips.parquet", shard=SHARDS),
        clips=expand("<results>/pose/{shard}/clips.parquet", shard=SHARDS),
        motions=expand("<results>/ingest/{shard}/motion.parquet", shard=SHARDS),
        origins=expand("<results>/ingest/{shard}/origins.parquet", shard=SHARDS),
        series=expand("<results>/series/{region}.parquet", region=SERIES_REGIONS),
        clusters=expand(
            "<results>/segment/{region}/clusters.parquet", region=SERIES_REGIONS
        ),
        labels="<results>/label/labels.parquet",
        exemplars="<results>/label/exemplars.parquet",
        profiles="<results>/label/profiles.parquet",
        intervals=expand("<results>/annotate/{shard}/intervals.parquet", shard=SHARDS),
        frames=expand("<results>/annotate/{shard}/frames.parquet", shard=SHARDS),
        split="<results>/split/split.parquet",
        duplicates="<results>/split/duplicates.parquet",
        descriptions="<results>/describe/descriptions.parquet",
        attributes="<results>/describe/attributes.parquet",
        weights="<results>/describe/weights.parquet",
        statistics="<results>/split/statistics.parquet",
        annotation_metrics="<results>/evaluate/annotation/metrics.parquet",
        confusion="<results>/evaluate/annotation/confusion.parquet",
        labelling="<results>/evaluate/labelling/metrics.parquet",
        checkpoints=expand(
            "<results>/train/{model}/checkpoint", model=config["train"]["models"]
        ),
        metrics=expand(
            "<results>/evaluate/{model}/metrics.parquet",
            model=config["train"]["models"],
        ),
        generated=expand(
            "<results>/evaluate/{model}/generated.parquet",
            model=config["train"]["models"],
        ),
        truth=TRUTH,
        face=ancient(config["report"]["face"] or []),
    output:
        page=report(
            "<results>/report/index.html",
            caption="../report/page.rst",
            category="Report",
            labels={"page": "all stages"},
        ),
    log:
        "<logs>/report.log",
    benchmark:
        "<benchmarks>/report.tsv"
    threads: 1
    resources:
        mem_mb=2000,
    params:
        report=lookup("report", within=config),
        models=config["train"]["models"],
        side=lookup("series/side", within=config),
        sources={
            key: config["fetch"][key]
            for key in ("folder", "max_pixels", "max_source_s", "max_mb", "timeout_s")
        },
        balance=lookup("describe/balance", within=config),
        annotate=lookup("annotate", within=config),
        overlap=lookup("evaluate/overlap", within=config),
        truth=listing(config["evaluate"]["truth"]),
        face=listing(config["report"]["face"]),
        code=code_digest("mimeline.reporting.report"),
    message:
        "Writing the report"
    script:
        "../scripts/report.py"
