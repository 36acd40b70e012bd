"""The configuration's sections, one per stage: each key with its unit and meaning."""

from typing import Annotated, Literal, get_args

from pydantic import Field, model_validator

from mimeline.config.catalogues import Catalogue
from mimeline.config.clips import Describe, Fetch, Pose, Select
from mimeline.config.section import Count, Positive, Section, Seed, Share
from mimeline.config.trackers import Ingest
from mimeline.vocabulary import CONTROL_REGIONS, SERIES_REGIONS

ControlRegion = Literal["brow", "eye", "mouth", "gaze", "head"]


class Toy(Section):
    """The toy world, made where data_dir is null."""

    people: Count = Field(40, description="people in the toy world")
    clips: Count = Field(120, description="clips, planted faults included")
    seed: Seed = Field(7, description="seed of everything random in the toy world")
    smiles_frown: Share = Field(
        0.0,
        description="share of the smiles that come with a lowered brow: a habit against which a "
        "smile with raised brows has to be made",
    )
    video_share: Share = Field(0.25, description="share of the clips that have a video")
    video_px: Annotated[int, Field(ge=32, le=1024, multiple_of=2)] = Field(
        256, description="edge of the videos, pixels"
    )
    tracker: Literal["livelink", "metrical_tracker"] = Field(
        "livelink", description="whose files the toy world's tracking results are written as"
    )


class Series(Section):
    side: Literal["left", "right"] = Field(
        "left", description="side of the face whose channels are clustered (Ma et al. 2025, 3.1)"
    )
    null_length: Count = Field(100, description="frames of a separator between two sequences")
    null_value: float = Field(-1.0, description="value of every channel in a separator")


class Ticc(Section):
    """Toeplitz inverse covariance-based clustering of one region."""

    n_clusters: Count = Field(9, description="clusters (Ma et al. 2025: brow 9, eye 8, mouth 9)")
    window: Count = Field(5, description="frames per window")
    beta: float = Field(
        20.0, ge=0, description="cost of a switch of cluster, nats: larger gives longer intervals"
    )
    sparsity: float = Field(0.11, ge=0, description="weight of the precision's l1 norm")
    boundary: Literal["mask", "paper"] = Field(
        "mask",
        description="mask: clips apart; paper: one series with the separators, clustered as well",
    )
    max_iter: Count = Field(30, description="most iterations of assignment and estimation")
    seed: Seed = Field(0, description="seed of the start")


class Segment(Section):
    brow: Ticc = Ticc()
    eye: Ticc = Ticc(n_clusters=8)
    mouth: Ticc = Ticc()


class Sweep(Section):
    """Fits over a grid, to choose n_clusters and beta by: snakemake sweep."""

    n_clusters: Annotated[list[Count], Field(min_length=1)] = Field(
        [3, 4, 5, 6, 7, 9, 12], description="cluster counts to try; the one of segment joins them"
    )
    beta: Annotated[list[Positive], Field(min_length=1)] = Field(
        [5.0, 10.0, 20.0, 40.0, 80.0],
        description="costs of a switch to try, nats; the one of segment joins them",
    )
    seeds: Count = Field(
        3, description="fits at each point, the first with segment's seed; 2 or more for stability"
    )


class Experiments(Section):
    """The experiments of Ma et al. 2025, 4.1, on these recordings: snakemake experiments.

    Cluster counts and betas are those of sweep."""

    seeds: Count = Field(3, description="fits of each setting, the first with segment's seed")
    unseen: Share = Field(
        0.2, description="share of the sources that are fitted without, and then annotated"
    )
    claspy: str | None = Field(
        None,
        description="Python interpreter of an environment with claspy, for the baseline CLaP; "
        "null: it is left out",
    )


class Label(Section):
    file: str | None = Field(
        None, description="YAML that `mimeline label` writes, names of clusters; null: as proposed"
    )
    min_agreement: Share = Field(
        0.8,
        description="share of a new cluster's known frames that must have borne one name before a "
        "refit for that name to be moved to it; else the run stops",
    )
    n_random: int = Field(2, ge=0, description="random exemplars per cluster")
    n_further: int = Field(
        7, ge=0, description="exemplars per cluster for a person who is not sure, beyond the first"
    )
    seed: Seed = Field(0, description="seed of the random exemplars")


class Annotate(Section):
    closed: Share = Field(0.5, description="eyeBlink from which an eye is closed, 0-1")
    gaze_deg: Positive = Field(8.0, description="gaze angle that counts as looking away, degrees")
    head_deg: Positive = Field(8.0, description="head angle that counts as turned, degrees")
    hysteresis: Share = Field(
        0.0,
        description="how far below its limit an action of closure, gaze or head may fall before it "
        "ends, share of the limit; 0: it ends at the limit (Ma et al. 2025, 3.1)",
    )
    min_frames: Count = Field(3, description="shortest interval that is kept, frames")


class Split(Section):
    val: Share = Field(0.05, description="share of clips for validation")
    test: Share = Field(0.05, description="share of clips for testing")
    gap_s: float = Field(
        1.0, ge=0, description="seconds left out between parts where blocks of time are split"
    )
    near_duplicates: Share | None = Field(
        0.5,
        description="two clips with more than that share of their pictures or of their movements "
        "alike are in one part; null: nobody looks",
    )
    seed: Seed = Field(0, description="seed of the assignment of groups")


class TimelineModel(Section):
    """Base-branch diffusion of Ma et al. 2025, 3.2."""

    window: Count = Field(64, description="frames per training window")
    width: Count = Field(64, description="width of the tokens")
    heads: Count = Field(4, description="attention heads")
    base_layers: int = Field(2, ge=0, description="layers of the base network; 0: no base")
    branch_layers: int = Field(1, ge=0, description="layers of each branch; 0: no branches")
    branches: Literal["halves", "regions"] = Field(
        "halves",
        description="what a branch makes: upper face, lower face, the rest; or brow, eyes, gaze, "
        "mouth, head, the rest",
    )
    timeline_tokens: Literal["initial", "carried"] = Field(
        "initial",
        description="what a layer reads of the timeline: initial, the timeline itself; carried, "
        "what the layer before made of it",
    )
    diffusion_steps: Annotated[int, Field(ge=10)] = Field(
        1000, description="steps of the noise schedule"
    )
    schedule: Literal["cosine", "linear"] = Field(
        "cosine", description="how the noise rises over the steps"
    )
    drop_all: Share = Field(0.1, description="chance that every region's timeline is dropped")
    drop_none: Share = Field(0.1, description="chance that no region's timeline is dropped")
    drop_each: Share = Field(0.5, description="chance that a region's timeline is dropped, else")
    steps: Count = Field(1000, description="training steps")
    batch: Count = Field(16, description="windows per step")
    learning_rate: Positive = Field(2e-3, description="peak learning rate of AdamW")
    ema: Share = Field(0.995, description="decay of the averaged weights")
    clip_norm: Positive = Field(1.0, description="largest norm of the gradient")
    save_every: Count = Field(
        500, description="steps between two saves of what resumes an interrupted training"
    )
    seed: Seed = Field(0, description="seed of weights, batches and noise")


class TrainHardware(Section):
    """Where a model is trained."""

    device: Literal["auto", "cpu", "cuda"] = Field(
        "auto", description="auto: a CUDA GPU where there is one"
    )
    precision: Literal["float32", "bfloat16", "float16"] = Field(
        "float32", description="of the network's arithmetic; float16 on a GPU only"
    )
    processes: Count = Field(
        1, description="processes that share each batch, one per core or GPU of this machine"
    )


class Train(Section):
    models: list[Literal["timeline"]] = Field(["timeline"], description="models to train")
    hardware: TrainHardware = TrainHardware()
    timeline: TimelineModel = TimelineModel()


class TimelineSampling(Section):
    """How the timeline model is asked for motion when it is scored."""

    sampler: Literal["ddpm", "ddim", "dpmpp_2m"] = Field(
        "dpmpp_2m",
        description="dpmpp_2m: few calls (Lu et al. 2022); ddim; ddpm: as many calls as the noise "
        "schedule has steps (Ho et al. 2020)",
    )
    sampler_steps: Count = Field(20, description="denoiser calls per sample")
    guidance: float = Field(2.0, ge=0, description="scale of classifier-free guidance; 1: none")
    region_guidance: dict[ControlRegion, Annotated[float, Field(ge=0)]] = Field(
        {},
        description="scales of regions that are to weigh more or less, {mouth: 3.0}; all others "
        "keep guidance",
    )
    guidance_interval: tuple[Share, Share] = Field(
        (0.1, 0.9),
        description="where in the noise schedule guidance is on, shares; 0: hardly any noise",
    )
    overlap: Annotated[float, Field(ge=0, lt=1)] = Field(
        0.25,
        description="share of a training window that neighbours have in common, where a timeline "
        "is longer",
    )
    precision: Literal["float32", "bfloat16"] = Field(
        "float32", description="of the network's arithmetic: float32 or bfloat16"
    )
    timelines: Count = Field(
        100, description="timelines asked for, from clips kept out of training"
    )
    seed: Seed = Field(0, description="seed of the choice of these clips, and of the noise")


class Evaluate(Section):
    truth: str | None = Field(
        None,
        description="what the annotation is scored against: a folder of timelines, a file per clip "
        "(.eaf, .TextGrid, .json, .csv, .vtt, .txt; `mimeline timeline export` makes them to be "
        "corrected), one such file, or a folder with frames.parquet; null: the toy's",
    )
    gmm_components: Count = Field(8, description="components of the GMM baseline")
    overlap: Positive = Field(
        0.5,
        le=1,
        description="intersection over union from which an interval counts as found",
    )
    looks: Count = Field(
        5, description="most intervals of a cluster that the simulated person looks at"
    )
    bootstrap: Count = Field(200, description="resamples of clips behind each interval")
    seed: Seed = Field(0, description="seed of baseline and resampling")
    timeline: TimelineSampling = TimelineSampling()


class Ablations(Section):
    """The ablation study of Ma et al. 2025, Table 2, on these recordings: snakemake ablations.

    A variant is the model of train.timeline with a few of its keys changed."""

    variants: Annotated[
        list[Literal["no-branch", "no-base", "regions", "carried", "depth", "drop"]],
        Field(min_length=1),
    ] = Field(
        ["no-branch", "no-base", "regions", "carried", "depth", "drop"],
        description="what is tried beside the configured model: no-branch, no-base: all layers in "
        "the other; regions: a branch for each region; carried: no layer but the first reads the "
        "timeline itself; depth: every other number of branch layers; drop: other chances of a "
        "region's timeline to be dropped (0, 0.3, 0.5, 0.7)",
    )
    seeds: Count = Field(3, description="trainings of each, the first with train.timeline's seed")
    timelines: Count = Field(80, description="made-up timelines of smiles with raised brows")
    frames: Annotated[int, Field(ge=136)] = Field(
        256, description="frames of such a timeline, of which the shortest holds a smile"
    )
    seed: Seed = Field(0, description="seed of these timelines")


class Report(Section):
    title: str = Field("mimeline on the toy world", description="title of the page")
    clips: Count = Field(6, description="clips whose timelines are drawn")
    exemplars: Count = Field(5, description="exemplars drawn per cluster")
    face: str | None = Field(
        None,
        description="a face to draw motion on: ICT-FaceKit, a folder of OBJ shapes, an npz; "
        "null: the embedded one",
    )


class Config(Section):
    """mimeline's configuration. Section and stage bear the same name."""

    data_dir: str | None = Field(
        None, description="folder of the recordings; null: the toy world, made on the way"
    )
    shards: Annotated[int, Field(ge=1, le=1000)] = Field(
        2, description="parts that the clips are worked on in"
    )
    pathvars: dict[Literal["results", "logs", "benchmarks"], str] = Field(
        {}, description="where the results go: {results: results-mine}; logs and benchmarks within"
    )
    toy: Toy = Toy()
    catalogue: Catalogue = Catalogue()
    select: Select = Select()
    fetch: Fetch = Fetch()
    ingest: Ingest = Ingest()
    pose: Pose = Pose()
    series: Series = Series()
    segment: Segment = Segment()
    sweep: Sweep = Sweep()
    experiments: Experiments = Experiments()
    label: Label = Label()
    annotate: Annotate = Annotate()
    describe: Describe = Describe()
    split: Split = Split()
    train: Train = Train()
    evaluate: Evaluate = Evaluate()
    ablations: Ablations = Ablations()
    report: Report = Report()

    @model_validator(mode="after")
    def _limits_agree(self) -> "Config":
        if self.select.min_s > self.select.max_s:
            raise ValueError("select.min_s to be at most select.max_s")
        if self.split.val + self.split.test >= 1:
            raise ValueError("split.val + split.test to be below 1, so that training has clips")
        model = self.train.timeline
        if model.drop_all + model.drop_none > 1:
            raise ValueError("train.timeline.drop_all + drop_none to be at most 1")
        if self.train.hardware.processes > model.batch:
            raise ValueError("train.hardware.processes to be at most train.timeline.batch")
        if not model.base_layers and not model.branch_layers:
            raise ValueError("train.timeline.base_layers or branch_layers to be 1 or more")
        low, high = self.evaluate.timeline.guidance_interval
        if low > high:
            raise ValueError("evaluate.timeline.guidance_interval to begin before it ends")
        if model.width % (2 * model.heads):
            raise ValueError("train.timeline.width to be a multiple of twice the heads")
        return self


assert set(SERIES_REGIONS) == set(Segment.model_fields)
assert get_args(ControlRegion) == CONTROL_REGIONS
