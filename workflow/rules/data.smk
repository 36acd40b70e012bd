from mimeline.media.confined import MEMORY_MB
from mimeline.vocabulary import REPRESENTATIONS

SHARDS = [f"{number:02d}" for number in range(config["shards"])]
TOY = config["data_dir"] is None
DATA = "<results>/toy/data" if TOY else ancient(config["data_dir"])
LISTING = listing(config["data_dir"])  # once: a file per frame makes many
LEDGERS = [  # of all that is decided on a clip before it is annotated
    "<results>/catalogue/ledger.parquet",
    *expand(
        "<results>/{stage}/{shard}/ledger.parquet",
        stage=["select", "fetch", "ingest", "pose"],
        shard=SHARDS,
    ),
]
TRUTH = config["evaluate"]["truth"] or ("<results>/toy/truth" if TOY else [])


rule toy:
    output:
        data=directory("<results>/toy/data"),
        truth=directory("<results>/toy/truth"),
    log:
        "<logs>/toy.log",
    benchmark:
        "<benchmarks>/toy.tsv"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        toy=lookup("toy", within=config),
        code=code_digest("mimeline.toy"),
    message:
        "Making the toy world"
    script:
        "../scripts/toy.py"


rule catalogue:
    input:
        data=DATA,
    output:
        clips=expand("<results>/catalogue/{shard}/clips.parquet", shard=SHARDS),
        ledger="<results>/catalogue/ledger.parquet",
    log:
        "<logs>/catalogue.log",
    benchmark:
        "<benchmarks>/catalogue.tsv"
    threads: 1
    resources:
        mem_mb=1000 + (MEMORY_MB if limits_of_videos(config) else 0),
    params:
        catalogue=chosen(config["catalogue"]),
        cut_s=lookup("catalogue/cut_s", within=config),
        tracker=tracker_of_takes(config),
        limits=limits_of_videos(config),
        shards=len(SHARDS),  # of fewer than before, every table is there already
        listing=LISTING,
        code=code_digest("mimeline.clips.catalogue"),
    message:
        "Reading what clips there are"
    script:
        "../scripts/catalogue.py"


rule select:
    input:
        clips="<results>/catalogue/{shard}/clips.parquet",
        exclusions=config["select"]["exclusions"] or [],
        # one shard looks for what the list excludes and nobody has
        catalogue=lambda wildcards: (
            rules.catalogue.output.ledger if wildcards.shard == SHARDS[0] else []
        ),
    output:
        clips="<results>/select/{shard}/clips.parquet",
        ledger="<results>/select/{shard}/ledger.parquet",
    log:
        "<logs>/select/{shard}.log",
    benchmark:
        "<benchmarks>/select/{shard}.tsv"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        select=lookup("select", within=config),
        code=code_digest("mimeline.clips.select"),
    message:
        "Selecting clips of shard {wildcards.shard}"
    script:
        "../scripts/select.py"


rule fetch:
    input:
        clips="<results>/select/{shard}/clips.parquet",
        data=DATA,
    output:
        clips="<results>/fetch/{shard}/clips.parquet",
        times="<results>/fetch/{shard}/source_times.parquet",
        fingerprints="<results>/fetch/{shard}/fingerprints.parquet",
        ledger="<results>/fetch/{shard}/ledger.parquet",
    log:
        "<logs>/fetch/{shard}.log",
    benchmark:
        "<benchmarks>/fetch/{shard}.tsv"
    threads: 1
    resources:
        mem_mb=1000 + MEMORY_MB,  # ours, and the most that ffmpeg may take
    params:
        fetch=lookup("fetch", within=config) | {"fps": rate_of_clips(config)},
        # beside the outputs and not one of them: what a killed run has cut is there for the next
        media=lambda wildcards, output: str(Path(output.clips).with_name("media")),
        sources=lambda wildcards, output: str(Path(output.clips).with_name("sources")),
        listing=LISTING,
        # what was cut by the same code is taken up
        recipe=code_digest("mimeline.media.cut", "mimeline.media.fingerprint"),
        code=code_digest("mimeline.clips.fetch"),
    message:
        "Cutting the videos of shard {wildcards.shard}"
    script:
        "../scripts/fetch.py"


rule ingest:
    input:
        clips="<results>/fetch/{shard}/clips.parquet",
        data=DATA,
    output:
        motion="<results>/ingest/{shard}/motion.parquet",
        coefficients=expand(
            "<results>/ingest/{{shard}}/{name}.parquet", name=REPRESENTATIONS
        ),
        origins="<results>/ingest/{shard}/origins.parquet",
        clips="<results>/ingest/{shard}/clips.parquet",
        ledger="<results>/ingest/{shard}/ledger.parquet",
    log:
        "<logs>/ingest/{shard}.log",
    benchmark:
        "<benchmarks>/ingest/{shard}.tsv"
    threads: 1
    resources:
        mem_mb=2000,
    params:
        ingest=chosen(config["ingest"]),
        mirrored=lookup("ingest/mirrored", within=config),
        bad_values=lookup("ingest/bad_values", within=config),
        max_missing=lookup("ingest/max_missing", within=config),
        max_loss=lookup("ingest/max_loss", within=config),
        max_reprojection=lookup("ingest/max_reprojection", within=config),
        face=listing(face_of_takes(config)),
        listing=LISTING,
        code=code_digest("mimeline.tracking.ingest"),
    message:
        "Reading tracking results of shard {wildcards.shard}"
    script:
        "../scripts/ingest.py"


rule pose:
    input:
        clips="<results>/ingest/{shard}/clips.parquet",
        motion="<results>/ingest/{shard}/motion.parquet",
        data=DATA,
    output:
        clips="<results>/pose/{shard}/clips.parquet",
        ledger="<results>/pose/{shard}/ledger.parquet",
    log:
        "<logs>/pose/{shard}.log",
    benchmark:
        "<benchmarks>/pose/{shard}.tsv"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        pose=chosen(config["pose"]),
        max_yaw_deg=lookup("pose/max_yaw_deg", within=config),
        listing=LISTING,
        code=code_digest("mimeline.clips.pose"),
    message:
        "Dropping turned heads of shard {wildcards.shard}"
    script:
        "../scripts/pose.py"
