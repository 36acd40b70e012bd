VARIANTS = variants(config["train"]["timeline"], config["ablations"]["variants"])
VARIANT_SEEDS = [
    config["train"]["timeline"]["seed"] + number
    for number in range(config["ablations"]["seeds"])
]


rule ablation_requests:
    input:
        frames=expand("<results>/annotate/{shard}/frames.parquet", shard=SHARDS),
        split="<results>/split/split.parquet",
    output:
        asked=expand("<results>/ablations/asked/{asked}.parquet", asked=ASKED),
    log:
        "<logs>/ablations/asked.log",
    benchmark:
        "<benchmarks>/ablations/asked.tsv"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        unseen=lookup("evaluate/timeline/timelines", within=config),
        choice_seed=lookup("evaluate/timeline/seed", within=config),
        timelines=lookup("ablations/timelines", within=config),
        length=lookup("ablations/frames", within=config),
        seed=lookup("ablations/seed", within=config),
        code=code_digest("mimeline.evaluation.requests"),
    message:
        "Drawing the timelines that all variants are asked for"
    script:
        "../scripts/ablation_requests.py"


rule train_variant:
    input:
        motions=expand("<results>/ingest/{shard}/motion.parquet", shard=SHARDS),
        frames=expand("<results>/annotate/{shard}/frames.parquet", shard=SHARDS),
        clips=expand("<results>/pose/{shard}/clips.parquet", shard=SHARDS),
        origins=expand("<results>/ingest/{shard}/origins.parquet", shard=SHARDS),
        split="<results>/split/split.parquet",
        statistics="<results>/split/statistics.parquet",
    output:
        checkpoint=directory("<results>/ablations/{variant}/{seed}/checkpoint"),
    log:
        "<logs>/ablations/{variant}/{seed}-train.log",
    benchmark:
        "<benchmarks>/ablations/{variant}/{seed}-train.tsv"
    wildcard_constraints:
        variant="|".join(VARIANTS),
        seed=r"\d+",
    threads: config["train"]["hardware"]["processes"]
    resources:
        mem_mb=3000 * config["train"]["hardware"]["processes"],
    params:
        options=lambda wildcards: {
            **config["train"]["timeline"],
            **VARIANTS[wildcards.variant].changes,
            "seed": int(wildcards.seed),
        },
        hardware=lookup("train/hardware", within=config),
        state=lambda wildcards, output: f"{Path(output.checkpoint).parent}.state",
        code=code_digest("mimeline.training.train"),
    message:
        "Training the variant {wildcards.variant}, seed {wildcards.seed}"
    script:
        "../scripts/train_variant.py"


rule generate_variant:
    input:
        checkpoint="<results>/ablations/{variant}/{seed}/checkpoint",
        asked=rules.ablation_requests.output.asked,
        motions=expand("<results>/ingest/{shard}/motion.parquet", shard=SHARDS),
        models=expand("<results>/segment/{region}/model", region=SERIES_REGIONS),
        labels="<results>/label/labels.parquet",
    output:
        made=expand(
            "<results>/ablations/{variant}/{seed}/{made}.parquet",
            made=MADE,
            allow_missing=True,
        ),
        found=expand(
            "<results>/ablations/{variant}/{seed}/{asked}-found.parquet",
            asked=ASKED,
            allow_missing=True,
        ),
    log:
        "<logs>/ablations/{variant}/{seed}-generate.log",
    benchmark:
        "<benchmarks>/ablations/{variant}/{seed}-generate.tsv"
    wildcard_constraints:
        variant="|".join(VARIANTS),
        seed=r"\d+",
    threads: 1
    resources:
        mem_mb=3000,
    params:
        annotate=lookup("annotate", within=config),
        sampling={
            key: value
            for key, value in config["evaluate"]["timeline"].items()
            if key not in ("timelines", "seed")
        },
        code=code_digest("mimeline.evaluation.variant_motion"),
    message:
        "Asking the variant {wildcards.variant}, seed {wildcards.seed}, for the timelines"
    script:
        "../scripts/generate_variant.py"


rule ablations:
    input:
        asked=rules.ablation_requests.output.asked,
        made=expand(
            "<results>/ablations/{variant}/{seed}/{made}.parquet",
            variant=VARIANTS,
            seed=VARIANT_SEEDS,
            made=MADE,
        ),
        found=expand(
            "<results>/ablations/{variant}/{seed}/{asked}-found.parquet",
            variant=VARIANTS,
            seed=VARIANT_SEEDS,
            asked=ASKED,
        ),
        motions=expand("<results>/ingest/{shard}/motion.parquet", shard=SHARDS),
        frames=expand("<results>/annotate/{shard}/frames.parquet", shard=SHARDS),
        clips=expand("<results>/pose/{shard}/clips.parquet", shard=SHARDS),
        split="<results>/split/split.parquet",
        paper=resource_table("paper_ablations.csv"),
    output:
        page="<results>/ablations/index.html",
        summary="<results>/ablations/summary.parquet",
    log:
        "<logs>/ablations.log",
    benchmark:
        "<benchmarks>/ablations.tsv"
    threads: 1
    resources:
        mem_mb=4000,
    params:
        trained=[(name, seed) for name in VARIANTS for seed in VARIANT_SEEDS],
        wanted=lookup("ablations/variants", within=config),
        configured=lookup("train/timeline", within=config),
        side=lookup("series/side", within=config),
        unseen=lookup("evaluate/timeline/timelines", within=config),
        choice_seed=lookup("evaluate/timeline/seed", within=config),
        resamples=lookup("evaluate/bootstrap", within=config),
        seed=lookup("evaluate/seed", within=config),
        code=code_digest("mimeline.reporting.ablations"),
    message:
        "The variants beside the paper's Table 2"
    script:
        "../scripts/ablations.py"
