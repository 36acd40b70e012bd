rule split:
    input:
        clips=expand("<results>/pose/{shard}/clips.parquet", shard=SHARDS),
        motions=expand("<results>/ingest/{shard}/motion.parquet", shard=SHARDS),
        fingerprints=expand(
            "<results>/fetch/{shard}/fingerprints.parquet", shard=SHARDS
        ),
    output:
        split="<results>/split/split.parquet",
        duplicates="<results>/split/duplicates.parquet",
        statistics="<results>/split/statistics.parquet",
        ledger="<results>/split/ledger.parquet",
    log:
        "<logs>/split.log",
    benchmark:
        "<benchmarks>/split.tsv"
    threads: 1
    resources:
        mem_mb=2000,
    params:
        split=lookup("split", within=config),
        code=code_digest("mimeline.dataset.split"),
    message:
        "Dividing the clips for training, validation and testing"
    script:
        "../scripts/split.py"


rule train:
    input:
        motions=expand("<results>/ingest/{shard}/motion.parquet", shard=SHARDS),
        frames=expand("<results>/annotate/{shard}/frames.parquet", shard=SHARDS),
        clips=expand("<results>/pose/{shard}/clips.parquet", shard=SHARDS),
        origins=expand("<results>/ingest/{shard}/origins.parquet", shard=SHARDS),
        split="<results>/split/split.parquet",
        statistics="<results>/split/statistics.parquet",
    output:
        checkpoint=directory("<results>/train/{model}/checkpoint"),
    log:
        "<logs>/train/{model}.log",
    benchmark:
        "<benchmarks>/train/{model}.tsv"
    threads: config["train"]["hardware"]["processes"]
    resources:
        mem_mb=3000 * config["train"]["hardware"]["processes"],
    params:
        options=lookup("train/{model}", within=config),
        hardware=lookup("train/hardware", within=config),
        # Undeclared, so that they outlive a run that fails.
        state=lambda wildcards, output: f"{Path(output.checkpoint).parent}.state",
        tensorboard=lambda wildcards, output: f"{Path(output.checkpoint).parent}.tensorboard",
        code=code_digest("mimeline.training.train"),
    message:
        "Training the {wildcards.model} model"
    script:
        "../scripts/train.py"


rule evaluate:
    input:
        checkpoint="<results>/train/{model}/checkpoint",
        motions=expand("<results>/ingest/{shard}/motion.parquet", shard=SHARDS),
        frames=expand("<results>/annotate/{shard}/frames.parquet", shard=SHARDS),
        split="<results>/split/split.parquet",
        models=expand("<results>/segment/{region}/model", region=SERIES_REGIONS),
        labels="<results>/label/labels.parquet",
    output:
        metrics="<results>/evaluate/{model}/metrics.parquet",
        generated="<results>/evaluate/{model}/generated.parquet",
    log:
        "<logs>/evaluate/{model}.log",
    benchmark:
        "<benchmarks>/evaluate/{model}.tsv"
    threads: 1
    resources:
        mem_mb=3000,
    params:
        annotate=lookup("annotate", within=config),
        resamples=lookup("evaluate/bootstrap", within=config),
        options=lookup("evaluate/{model}", within=config),
        code=code_digest("mimeline.evaluation.timeline"),
    message:
        "Scoring the {wildcards.model} model"
    script:
        "../scripts/evaluate.py"
