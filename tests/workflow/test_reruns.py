"""What a changed key, changed code or nothing at all makes run again."""

import copy
import os
import types
import typing
from functools import cache, reduce
from pathlib import Path

import pytest
import yaml

from mimeline.config import Config, Section
from mimeline.config.catalogues import Catalogue
from mimeline.config.trackers import OF_FACE_MODELS
from mimeline.tracking.readers import READERS
from mimeline.vocabulary import SERIES_REGIONS

AFTER_POSE = {
    "series",
    "segment",
    "exemplars",
    "label",
    "annotate",
    "describe",
    "split",
    "train",
    "evaluate",
}
AFTER_POSE |= {"evaluate_annotation", "evaluate_labelling", "report"}
AFTER_LABEL = {"annotate", "describe", "train", "evaluate", "evaluate_annotation", "report"}
AFTER_SEGMENT = {"exemplars", "evaluate_labelling", "label"} | AFTER_LABEL

# Which rules use a key: the longest prefix that matches it. A section's keys belong to the rule of
# its name; what other rules use besides is told here.
USERS: dict[str, set[str]] = {
    "toy": {"toy"},
    "catalogue": {"catalogue"},
    "select": {"select"},
    "fetch": {"fetch"},
    **{
        f"fetch.{key}": {"fetch", "report"}
        for key in ("folder", "max_pixels", "max_source_s", "max_mb", "timeout_s")
    },
    "ingest": {"ingest"},
    "ingest.format": {"ingest", "fetch"},
    **{f"ingest.{name}.face": {"ingest"} for name in OF_FACE_MODELS},
    **{f"ingest.{name}.fps": {"ingest", "fetch"} for name in READERS},
    "ingest.pyfeat.stride": {"ingest", "fetch"},
    "pose": {"pose"},
    "series": {"series"},
    "series.side": {
        "series",
        "segment",
        "sweep_region",
        "experiment_region",
        "experiments",
        "exemplars",
        "evaluate_annotation",
        "ablations",
        "report",
    },
    "series.null_length": {"series", "segment", "sweep_region", "experiment_region"},
    "series.null_value": {"series", "segment", "sweep_region", "experiment_region"},
    "segment": {"segment", "sweep_region", "experiment_region"},
    **{
        f"segment.{region}.{key}": {
            *("segment", "sweep_region", "sweep", "experiment_region", "experiments")
        }
        for region in SERIES_REGIONS
        for key in ("n_clusters", "beta")
    },
    **{
        f"segment.{region}.boundary": {
            *("segment", "sweep_region", "experiment_region", "experiments")
        }
        for region in SERIES_REGIONS
    },
    "sweep": {"sweep_region", "experiment_region"},
    "sweep.seeds": {"sweep_region"},
    "experiments": {"experiment_region"},
    "label": {"exemplars"},
    "label.file": {"label"},
    "label.min_agreement": {"label"},
    "annotate": {"annotate", "evaluate_annotation", "evaluate", "generate_variant", "report"},
    "describe": {"describe"},
    "describe.balance": {"describe", "report"},
    "split": {"split"},
    "train.hardware": {"train", "train_variant"},
    "train.timeline": {"train", "train_variant", "ablations"},
    "train.timeline.seed": {"train", "ablations"},  # a variant of one seed stays what it is
    "evaluate.truth": {
        "evaluate_annotation",
        "evaluate_labelling",
        "sweep_region",
        "experiment_region",
        "report",
    },
    "evaluate.gmm_components": {"evaluate_annotation"},
    "evaluate.overlap": {"evaluate_annotation", "report"},
    "evaluate.bootstrap": {"evaluate_annotation", "evaluate", "experiments", "ablations"},
    "evaluate.seed": {"evaluate_annotation", "evaluate_labelling", "experiments", "ablations"},
    "evaluate.looks": {"evaluate_labelling"},
    "evaluate.timeline": {"evaluate", "generate_variant"},
    **{
        f"evaluate.timeline.{key}": {"evaluate", "ablation_requests", "ablations"}
        for key in ("timelines", "seed")
    },
    "ablations": {"ablation_requests"},
    "report": {"report"},
}
# A block of a format counts where its format is chosen, and only there.
FORMATS = {
    "catalogue.celebvtext": {},
    **{
        f"catalogue.{name}": {"catalogue": {"format": name}}
        for name in ("celebvhq", "realtalk", "mead", "ravdess", "table", "files", "videos")
    },
    "ingest.livelink": {},
    **{f"ingest.{name}": {"ingest": {"format": name}} for name in READERS if name != "livelink"},
    "pose.sixdrepnet": {},
    "pose.openface": {"pose": {"format": "openface"}},
}
# Files and folders that must be there.
FILES = {"select.exclusions", "describe.templates", "label.file", "evaluate.truth", "report.face"}
# These change which jobs there are, or where their files lie, not the params of a rule.
STRUCTURE = {"data_dir", "shards", "pathvars", "train.models"}
STRUCTURE |= {"ablations.variants", "ablations.seeds"}
# These do besides: of the variants of the ablation study, some go and others come.
OF_VARIANTS = {
    f"train.timeline.{key}"
    for key in ("base_layers", "branch_layers", "branches", "timeline_tokens", "drop_each", "seed")
}


def leaves(section: type[Section], prefix: str = ""):
    for name, field in section.model_fields.items():
        if isinstance(field.annotation, type) and issubclass(field.annotation, Section):
            yield from leaves(field.annotation, f"{prefix}{name}.")
        elif f"{prefix}{name}" not in STRUCTURE:
            yield f"{prefix}{name}", field


KEYS = dict(leaves(Config))


def another(key: str, field, value):
    """A value that the key allows and that differs from this one."""
    literal = next((a for a in _options(field.annotation) if a != value), None)
    if literal is not None:
        return literal
    special = {
        "catalogue.mead.views": ["top"],
        "select.conditions": ["duration_s < 8"],
        "select.exclusions": "left-out.csv",
        "describe.templates": "templates.yaml",
        "label.file": "names.yaml",
        "fetch.url": "http://127.0.0.1/{source_id}.mp4",
        "evaluate.truth": "truth",
        "report.face": "face.npz",
        "catalogue.cut_s": 7.5,
        "ingest.max_loss": 0.5,
        "ingest.table.channels": {"jawOpen": {"column": "jaw"}},
        "sweep.n_clusters": [2],
        "sweep.beta": [3.0],
        "toy.video_px": 128,
        "fetch.side_px": 128,
        "train.timeline.width": 128,
        "train.timeline.heads": 2,
        "evaluate.timeline.region_guidance": {"mouth": 3.0},
        "evaluate.timeline.guidance_interval": [0.2, 0.8],
    }
    if key in special:
        return special[key]
    if isinstance(value, list):
        return [*value, "another"]
    if isinstance(value, int):
        return value + 1
    if isinstance(value, float):
        return value * 0.9 + 0.003
    return "50" if key.endswith("fps") else f"another-{value}"


def _options(annotation) -> tuple:
    if typing.get_origin(annotation) is typing.Literal:
        return typing.get_args(annotation)
    if isinstance(annotation, types.UnionType):
        return sum((_options(a) for a in typing.get_args(annotation)), ())
    return ()


def users(key: str) -> set[str]:
    prefixes = [prefix for prefix in USERS if key == prefix or key.startswith(prefix + ".")]
    return USERS[max(prefixes, key=len)]


def nested(key: str, value) -> dict:
    return reduce(lambda inner, part: {part: inner}, reversed(key.split(".")), value)


def merged(*configs: dict) -> dict:
    result: dict = {}
    for config in configs:
        for key, value in copy.deepcopy(config).items():
            old = result.get(key)
            both = isinstance(value, dict) and isinstance(old, dict)
            result[key] = merged(old, value) if both else value
    return result


@pytest.fixture(scope="module")
def params_of_format(job_params):
    """Params of all jobs where a block of FORMATS counts; most keys share them."""
    return cache(lambda block: job_params(FORMATS.get(block, {})))


@pytest.mark.parametrize("key", KEYS)
def test_a_key_changes_the_params_of_exactly_the_rules_that_use_it(
    job_params, params_of_format, tmp_path, key
):
    block = next((b for b in FORMATS if key.startswith(b + ".")), None)
    base = FORMATS.get(block, {})
    default = reduce(getattr, key.split("."), Config())
    value = another(key, KEYS[key], default)
    if key in FILES:
        value = str(tmp_path / value)
        if key.endswith("truth"):
            Path(value).mkdir()
        else:
            Path(value).write_text("clip_id,reason\n")
    before = params_of_format(block)
    after = job_params(merged(base, nested(key, value)))
    assert key in OF_VARIANTS or before.keys() == after.keys()
    common = before.keys() & after.keys()
    changed = {job[0] for job in common if before[job] != after[job]}
    expected = users(key)
    if key.startswith("ingest.") and base.get("catalogue", {}).get("format") == "files":
        expected = expected | {"catalogue"}
    assert changed == expected


def test_a_region_of_segment_changes_that_region_alone(job_params):
    before, after = job_params({}), job_params({"segment": {"eye": {"beta": 9}}})
    changed = {job for job in before if before[job] != after[job]}
    assert changed == {
        ("segment", ("eye",)),
        ("sweep_region", ("eye",)),
        ("sweep", ()),
        ("experiment_region", ("eye",)),
        ("experiments", ()),
    }


@pytest.mark.parametrize("name", typing.get_args(Catalogue.model_fields["format"].annotation))
def test_a_dry_run_with_a_catalogue_plans_the_whole_way_and_reads_its_block_alone(
    job_params, tmp_path, name
):
    jobs = job_params({"catalogue": {"format": name}, "data_dir": str(tmp_path)})
    assert {rule for rule, _ in jobs} >= {"catalogue", "select", "fetch", "describe", "report"}
    assert "toy" not in {rule for rule, _ in jobs}
    block = getattr(Catalogue(), name).model_dump()
    assert jobs["catalogue", ()]["catalogue"] == {"format": name, "options": block}


def test_keys_of_a_format_that_is_not_chosen_change_nothing(job_params):
    for key in ("ingest.pyfeat.fps", "catalogue.files.pattern"):
        assert job_params({}) == job_params(nested(key, "50"))


def test_a_catalogue_of_files_depends_on_how_takes_are_read(job_params, tmp_path):
    base = {"catalogue": {"format": "files"}, "data_dir": str(tmp_path)}
    before = job_params(base)
    after = job_params(merged(base, {"ingest": {"livelink": {"fps": "60"}}}))
    changed = {job[0] for job in before if before[job] != after[job]}
    assert changed == {"catalogue", "fetch", "ingest"}


def test_a_new_file_in_data_dir_reruns_what_reads_the_folder(job_params, tmp_path):
    before = job_params({"data_dir": str(tmp_path)})
    (tmp_path / "new.csv").write_text("new")
    after = job_params({"data_dir": str(tmp_path)})
    changed = {job[0] for job in before if before[job] != after[job]}
    assert changed == {"catalogue", "fetch", "ingest", "pose"}


def test_a_catalogue_of_videos_depends_on_what_a_video_may_ask_of_us(job_params, tmp_path):
    base = {"catalogue": {"format": "videos"}, "data_dir": str(tmp_path)}
    before = job_params(base)
    after = job_params(merged(base, {"fetch": {"max_source_s": 60}}))
    changed = {job[0] for job in before if before[job] != after[job]}
    assert changed == {"catalogue", "fetch", "report"}


def test_a_changed_file_of_the_face_reruns_the_report(job_params, tmp_path):
    base = {"report": {"face": str(tmp_path)}}
    (tmp_path / "neutral.obj").write_text("v 0 0 0")
    before = job_params(base)
    (tmp_path / "neutral.obj").write_text("v 0 0 0.1")
    after = job_params(base)
    assert {job[0] for job in before if before[job] != after[job]} == {"report"}


def test_what_is_wanted_of_the_ablation_study_is_what_is_trained(job_params):
    wanted = {"variants": ["carried", "regions"], "seeds": 2}
    jobs = job_params({"ablations": wanted, "train": {"timeline": {"seed": 5}}})
    trained = {(name, seed) for name in ("ours", "carried", "regions") for seed in ("5", "6")}
    for rule in ("train_variant", "generate_variant"):
        assert {wildcards for name, wildcards in jobs if name == rule} == trained
    options = jobs["train_variant", ("carried", "6")]["options"]
    configured = jobs["train", ("timeline",)]["options"]
    assert options == {**configured, "timeline_tokens": "carried", "seed": 6}


def test_more_shards_mean_more_jobs_of_the_sharded_rules(job_params):
    sharded = {job[0] for job in job_params({"shards": 5}) if job[1] == ("04",)}
    assert sharded == {"select", "fetch", "ingest", "pose", "annotate"}


def test_a_second_run_has_nothing_to_do(toy_run):
    assert toy_run.would_rerun() == set()


DRY_RUNS = {
    "toy.seed": (4, {"toy", "catalogue", "select", "fetch", "ingest", "pose"} | AFTER_POSE),
    "catalogue.cut_s": (7.5, {"catalogue", "select", "fetch", "ingest", "pose"} | AFTER_POSE),
    "select.max_s": (9.5, {"select", "fetch", "ingest", "pose"} | AFTER_POSE),
    "fetch.side_px": (32, {"fetch", "ingest", "pose"} | AFTER_POSE),
    "ingest.max_missing": (0.2, {"ingest", "pose"} | AFTER_POSE),
    "pose.max_yaw_deg": (30, {"pose"} | AFTER_POSE),
    "series.null_length": (50, AFTER_POSE - {"split"}),
    "segment.brow.beta": (6, {"segment"} | AFTER_SEGMENT),
    "label.n_random": (3, AFTER_SEGMENT),
    "label.min_agreement": (0.9, {"label"} | AFTER_LABEL),
    "evaluate.looks": (3, {"evaluate_labelling", "report"}),
    "annotate.closed": (0.4, AFTER_LABEL),
    "split.seed": (1, {"split", "train", "evaluate", "report"}),
    "train.timeline.steps": (11, {"train", "evaluate", "report"}),
    "train.hardware.precision": ("bfloat16", {"train", "evaluate", "report"}),
    "evaluate.timeline.guidance": (1.5, {"evaluate", "report"}),
    "report.title": ("Another title", {"report"}),
}


@pytest.fixture(scope="module")
def rerun_after(toy_run, tmp_path_factory) -> dict[str, set[str]]:
    """What each key of DRY_RUNS makes run again."""
    folder = tmp_path_factory.mktemp("changes")
    changes = {key: folder / f"{key}.yaml" for key in DRY_RUNS}
    for key, path in changes.items():
        path.write_text(yaml.safe_dump(nested(key, DRY_RUNS[key][0])))
    reruns = toy_run.would_rerun_each(map(str, changes.values()))
    return dict(zip(changes, reruns, strict=True))


@pytest.mark.parametrize("key", DRY_RUNS)
def test_a_dry_run_after_a_change_names_that_stage_and_those_after_it(rerun_after, key):
    assert rerun_after[key] == DRY_RUNS[key][1]


def test_changed_code_reruns_what_imports_it_and_a_comment_does_not(toy_run):
    path = toy_run.root / "src" / "mimeline" / "annotation" / "exemplars.py"
    text = path.read_text()
    try:
        path.write_text(text + "\n# a remark\n")
        assert toy_run.would_rerun() == set()
        path.write_text(text + "\nLEAST_RUNS = 3\n")
        rerun = toy_run.would_rerun()
    finally:
        path.write_text(text)
    assert {"exemplars", "label", "annotate", "report"} <= rerun
    assert not rerun & {"toy", "catalogue", "select", "ingest", "pose", "segment", "split"}


def test_a_changed_resource_table_reruns_the_rules_that_use_it(toy_run):
    path = toy_run.root / "resources" / "proposals.csv"
    text, written = path.read_text(), path.stat()
    try:
        path.write_text(text.replace("0.15", "0.16"))
        rerun = toy_run.would_rerun()
    finally:
        path.write_text(text)
        os.utime(path, ns=(written.st_atime_ns, written.st_mtime_ns))
    assert "exemplars" in rerun
    assert "segment" not in rerun
