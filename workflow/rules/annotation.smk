rule series:
    input:
        clips=expand("<results>/pose/{shard}/clips.parquet", shard=SHARDS),
        motions=expand("<results>/ingest/{shard}/motion.parquet", shard=SHARDS),
    output:
        series="<results>/series/{region}.parquet",
    log:
        "<logs>/series/{region}.log",
    benchmark:
        "<benchmarks>/series/{region}.tsv"
    threads: 1
    resources:
        mem_mb=2000,
    params:
        series=lookup("series", within=config),
        code=code_digest("mimeline.annotation.series"),
    message:
        "Joining all clips into the {wildcards.region} series"
    script:
        "../scripts/series.py"


rule segment:
    input:
        series="<results>/series/{region}.parquet",
    output:
        model=directory("<results>/segment/{region}/model"),
        clusters="<results>/segment/{region}/clusters.parquet",
    log:
        "<logs>/segment/{region}.log",
    benchmark:
        "<benchmarks>/segment/{region}.tsv"
    threads: 1
    resources:
        mem_mb=2000,
    params:
        segment=lookup("segment/{region}", within=config),
        side=lookup("series/side", within=config),
        null_length=lookup("series/null_length", within=config),
        null_value=lookup("series/null_value", within=config),
        code=code_digest("mimeline.annotation.segment"),
    message:
        "TICC on the {wildcards.region} series"
    script:
        "../scripts/segment.py"


rule sweep_region:
    input:
        clips=expand("<results>/pose/{shard}/clips.parquet", shard=SHARDS),
        ledgers=LEDGERS,
        series="<results>/series/{region}.parquet",
        truth=TRUTH,
    output:
        scores="<results>/sweep/{region}.parquet",
    log:
        "<logs>/sweep/{region}.log",
    benchmark:
        "<benchmarks>/sweep/{region}.tsv"
    threads: 1
    resources:
        mem_mb=2000,
    params:
        sweep=lookup("sweep", within=config),
        segment=lookup("segment/{region}", within=config),
        side=lookup("series/side", within=config),
        null_length=lookup("series/null_length", within=config),
        null_value=lookup("series/null_value", within=config),
        truth=listing(config["evaluate"]["truth"]),
        code=code_digest("mimeline.evaluation.sweep"),
    message:
        "TICC on the {wildcards.region} series, over cluster counts and betas"
    script:
        "../scripts/sweep_region.py"


rule sweep:
    input:
        scores=expand("<results>/sweep/{region}.parquet", region=SERIES_REGIONS),
    output:
        page="<results>/sweep/index.html",
    log:
        "<logs>/sweep.log",
    benchmark:
        "<benchmarks>/sweep.tsv"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        n_clusters=[config["segment"][r]["n_clusters"] for r in SERIES_REGIONS],
        beta=[config["segment"][r]["beta"] for r in SERIES_REGIONS],
        code=code_digest("mimeline.reporting.sweep"),
    message:
        "Drawing the scores over cluster counts and betas"
    script:
        "../scripts/sweep.py"


rule experiment_region:
    input:
        clips=expand("<results>/pose/{shard}/clips.parquet", shard=SHARDS),
        ledgers=LEDGERS,
        motions=expand("<results>/ingest/{shard}/motion.parquet", shard=SHARDS),
        units=expand("<results>/ingest/{shard}/action_units.parquet", shard=SHARDS),
        rules=resource_table("proposals.csv"),
        truth=TRUTH,
    output:
        found="<results>/experiments/{region}.parquet",
        left_out="<results>/experiments/{region}-left-out.parquet",
    log:
        "<logs>/experiments/{region}.log",
    benchmark:
        "<benchmarks>/experiments/{region}.tsv"
    threads: 1
    resources:
        mem_mb=3000,
    params:
        experiments=lookup("experiments", within=config),
        n_clusters=lookup("sweep/n_clusters", within=config),
        betas=lookup("sweep/beta", within=config),
        segment=lookup("segment/{region}", within=config),
        side=lookup("series/side", within=config),
        null_length=lookup("series/null_length", within=config),
        null_value=lookup("series/null_value", within=config),
        truth=listing(config["evaluate"]["truth"]),
        code=code_digest("mimeline.evaluation.experiments"),
    message:
        "The paper's experiments on the {wildcards.region} series"
    script:
        "../scripts/experiment_region.py"


rule experiments:
    input:
        found=expand("<results>/experiments/{region}.parquet", region=SERIES_REGIONS),
        left_out=expand(
            "<results>/experiments/{region}-left-out.parquet", region=SERIES_REGIONS
        ),
        annotation="<results>/evaluate/annotation/metrics.parquet",
        paper=resource_table("paper_scores.csv"),
    output:
        page="<results>/experiments/index.html",
        summary="<results>/experiments/summary.parquet",
    log:
        "<logs>/experiments.log",
    benchmark:
        "<benchmarks>/experiments.tsv"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        configured=[
            {
                key: config["segment"][region][key]
                for key in ("n_clusters", "beta", "boundary")
            }
            for region in SERIES_REGIONS
        ],
        side=lookup("series/side", within=config),
        resamples=lookup("evaluate/bootstrap", within=config),
        seed=lookup("evaluate/seed", within=config),
        code=code_digest("mimeline.reporting.experiments"),
    message:
        "The experiments beside the paper's numbers"
    script:
        "../scripts/experiments.py"


rule exemplars:
    input:
        series=expand("<results>/series/{region}.parquet", region=SERIES_REGIONS),
        clusters=expand(
            "<results>/segment/{region}/clusters.parquet", region=SERIES_REGIONS
        ),
        models=expand("<results>/segment/{region}/model", region=SERIES_REGIONS),
        rules=resource_table("proposals.csv"),
    output:
        proposed="<results>/label/proposed.parquet",
        exemplars="<results>/label/exemplars.parquet",
        profiles="<results>/label/profiles.parquet",
    log:
        "<logs>/exemplars.log",
    benchmark:
        "<benchmarks>/exemplars.tsv"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        n_random=lookup("label/n_random", within=config),
        n_further=lookup("label/n_further", within=config),
        seed=lookup("label/seed", within=config),
        side=lookup("series/side", within=config),
        code=code_digest("mimeline.annotation.exemplars"),
    message:
        "Choosing exemplars of the clusters, proposing names"
    script:
        "../scripts/exemplars.py"


rule label:
    input:
        proposed="<results>/label/proposed.parquet",
        clusters=expand(
            "<results>/segment/{region}/clusters.parquet", region=SERIES_REGIONS
        ),
        models=expand("<results>/segment/{region}/model", region=SERIES_REGIONS),
        file=config["label"]["file"] or [],
    output:
        labels="<results>/label/labels.parquet",
        names="<results>/label/labels.yaml",
    log:
        "<logs>/label.log",
    benchmark:
        "<benchmarks>/label.tsv"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        file=lookup("label/file", within=config),
        min_agreement=lookup("label/min_agreement", within=config),
        code=code_digest("mimeline.annotation.labels"),
    message:
        "Naming the clusters"
    script:
        "../scripts/label.py"


rule annotate:
    input:
        clips="<results>/pose/{shard}/clips.parquet",
        motion="<results>/ingest/{shard}/motion.parquet",
        clusters=expand(
            "<results>/segment/{region}/clusters.parquet", region=SERIES_REGIONS
        ),
        labels="<results>/label/labels.parquet",
    output:
        intervals="<results>/annotate/{shard}/intervals.parquet",
        frames="<results>/annotate/{shard}/frames.parquet",
    log:
        "<logs>/annotate/{shard}.log",
    benchmark:
        "<benchmarks>/annotate/{shard}.tsv"
    threads: 1
    resources:
        mem_mb=2000,
    params:
        annotate=lookup("annotate", within=config),
        code=code_digest("mimeline.annotation.annotate"),
    message:
        "Writing the timelines of shard {wildcards.shard}"
    script:
        "../scripts/annotate.py"


rule evaluate_annotation:
    input:
        clips=expand("<results>/pose/{shard}/clips.parquet", shard=SHARDS),
        ledgers=LEDGERS,
        motions=expand("<results>/ingest/{shard}/motion.parquet", shard=SHARDS),
        frames=expand("<results>/annotate/{shard}/frames.parquet", shard=SHARDS),
        series=expand("<results>/series/{region}.parquet", region=SERIES_REGIONS),
        clusters=expand(
            "<results>/segment/{region}/clusters.parquet", region=SERIES_REGIONS
        ),
        rules=resource_table("proposals.csv"),
        truth=TRUTH,
    output:
        metrics="<results>/evaluate/annotation/metrics.parquet",
        confusion="<results>/evaluate/annotation/confusion.parquet",
    log:
        "<logs>/evaluate/annotation.log",
    benchmark:
        "<benchmarks>/evaluate/annotation.tsv"
    threads: 1
    resources:
        mem_mb=2000,
    params:
        side=lookup("series/side", within=config),
        annotate=lookup("annotate", within=config),
        gmm_components=lookup("evaluate/gmm_components", within=config),
        overlap=lookup("evaluate/overlap", within=config),
        resamples=lookup("evaluate/bootstrap", within=config),
        seed=lookup("evaluate/seed", within=config),
        truth=listing(config["evaluate"]["truth"]),
        code=code_digest("mimeline.evaluation.annotation"),
    message:
        "Scoring the annotation against the truth"
    script:
        "../scripts/evaluate_annotation.py"


rule evaluate_labelling:
    input:
        clips=expand("<results>/pose/{shard}/clips.parquet", shard=SHARDS),
        ledgers=LEDGERS,
        clusters=expand(
            "<results>/segment/{region}/clusters.parquet", region=SERIES_REGIONS
        ),
        proposed="<results>/label/proposed.parquet",
        exemplars="<results>/label/exemplars.parquet",
        truth=TRUTH,
    output:
        metrics="<results>/evaluate/labelling/metrics.parquet",
    log:
        "<logs>/evaluate/labelling.log",
    benchmark:
        "<benchmarks>/evaluate/labelling.tsv"
    threads: 1
    resources:
        mem_mb=2000,
    params:
        looks=lookup("evaluate/looks", within=config),
        seed=lookup("evaluate/seed", within=config),
        truth=listing(config["evaluate"]["truth"]),
        code=code_digest("mimeline.evaluation.labelling"),
    message:
        "Naming the clusters as a simulated person would"
    script:
        "../scripts/evaluate_labelling.py"


rule describe:
    input:
        clips=expand("<results>/pose/{shard}/clips.parquet", shard=SHARDS),
        intervals=expand("<results>/annotate/{shard}/intervals.parquet", shard=SHARDS),
        templates=config["describe"]["templates"] or [],
    output:
        descriptions="<results>/describe/descriptions.parquet",
        attributes="<results>/describe/attributes.parquet",
        weights="<results>/describe/weights.parquet",
    log:
        "<logs>/describe.log",
    benchmark:
        "<benchmarks>/describe.tsv"
    threads: 1
    resources:
        mem_mb=4000,
    params:
        describe=lookup("describe", within=config),
        code=code_digest("mimeline.clips.description.describe"),
    message:
        "Describing the clips in sentences"
    script:
        "../scripts/describe.py"
