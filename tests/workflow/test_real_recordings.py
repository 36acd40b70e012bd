"""The examples of config/examples run on real recordings, or on small takes of their format.

Three go to their report: with all channels, with short clips, with the head alone. The others stop
once what is special about their format has happened.
"""

from pathlib import Path

import pytest
import yaml

from mimeline import tables
from mimeline.config import validate
from mimeline.tracking.readers import Tracker
from mimeline.vocabulary import EXPRESSIONS, GAZE, HEAD
from mimeline.workflow import chosen

EXAMPLES = Path(__file__).parents[2] / "config" / "examples"
GOLDEN = Path(__file__).parents[1] / "tracking" / "golden"
SMALL = """
shards: 1
train: {timeline: {width: 16, heads: 2, steps: 5, batch: 2}}
evaluate: {timeline: {timelines: 1, sampler_steps: 2}}
report: {clips: 1, exemplars: 1}
"""


@pytest.fixture
def run_example(checkout, tmp_path):
    """Run an example on a data folder with a few changed keys; returns its folder of results."""

    def run_example(name: str, data: Path, *arguments: str, change: str = SMALL) -> Path:
        small = tmp_path / "small.yaml"
        small.write_text(change)
        config = (f"config/examples/{name}.yaml", str(small))
        done = checkout.run(*arguments, "--config", f"data_dir={data}", config=config)
        assert done.returncode == 0, done.stdout + done.stderr
        return checkout.root / f"results-{name}"

    return run_example


def test_an_example_ends_with_a_report(run_example, real_data):
    results = run_example("livelink", real_data / "arkit_livelink")
    assert (results / "report" / "index.html").stat().st_size > 10_000
    frames = tables.read_all(tables.FRAMES, results.glob("annotate/*/frames.parquet"))
    assert frames["clip_id"].nunique() == 13
    for action in ("HeadLeft", "HeadUp"):
        assert frames[action].isna().all()
    assert frames["BrowUp"].notna().any()
    metrics = results / "evaluate" / "annotation" / "metrics.parquet"
    assert tables.reason(metrics) == "no truth is known for these recordings"


def test_an_example_that_measures_the_head_alone_ends_with_a_report(run_example, real_data):
    results = run_example("dreamtalk", real_data / "dreamtalk")
    page = (results / "report" / "index.html").read_text(encoding="utf-8")
    assert "no face model was given" in page
    assert clips_after_pose(results) == 16
    assert measured(results) == set(HEAD)
    frames = tables.read_all(tables.FRAMES, results.glob("annotate/*/frames.parquet"))
    assert frames["BrowUp"].isna().all()
    assert frames["HeadUp"].notna().all()


def test_an_example_of_short_clips_ends_with_a_report(run_example, real_data):
    results = run_example("pyfeat", real_data / "pyfeat")
    assert (results / "report" / "index.html").stat().st_size > 10_000
    metrics = results / "evaluate" / "annotation" / "metrics.parquet"
    assert tables.reason(metrics) == "no truth is known for these recordings"
    frames = tables.read_all(tables.FRAMES, results.glob("annotate/*/frames.parquet"))
    assert frames["clip_id"].nunique() == 10
    assert frames["BrowUp"].notna().any()


def test_an_example_reads_real_recordings(run_example, real_data):
    results = run_example("openface", real_data / "openface", "--until", "pose")
    found = measured(results)
    assert clips_after_pose(results) == 1
    assert {*HEAD, *GAZE, "jawOpen", "browInnerUp"} <= found
    assert "tongueOut" not in found


def small_takes(name: str, folder: Path) -> tuple[Path, dict]:
    """A folder of the small takes of a format, and how these are to be read."""
    folder.mkdir()
    for take in (GOLDEN / name).iterdir():
        if take.name != "options.yaml":
            (folder / take.name).symlink_to(take)
    return folder, yaml.safe_load((GOLDEN / name / "options.yaml").read_text())


def test_an_example_takes_folders_for_takes(run_example, tmp_path):
    data, options = small_takes("metrical_tracker", tmp_path / "takes")
    change = {"shards": 1, "select": {"min_s": 0.1}, "ingest": {"metrical_tracker": options}}
    results = run_example(
        "metrical_tracker", data, "--until", "pose", change=yaml.safe_dump(change)
    )
    assert clips_after_pose(results) == len(list(data.iterdir()))
    assert {*HEAD, *GAZE, "eyeBlinkLeft"} <= measured(results)


@pytest.mark.parametrize(
    ("name", "channels"),
    [("mediapipe", {*HEAD, *EXPRESSIONS} - {"tongueOut"}), ("emoca", {*HEAD, "jawOpen"})],
)
def test_an_example_reads_small_takes_of_its_format(tmp_path, name, channels):
    data, options = small_takes(name, tmp_path / "takes")
    example = yaml.safe_load((EXAMPLES / f"{name}.yaml").read_text())
    example["ingest"][name] |= options
    ingest = validate(example | {"data_dir": str(data)})["ingest"]
    tracker = Tracker.of(data, **chosen(ingest), bad_values=ingest["bad_values"])
    takes = tracker.takes()
    assert len(takes) == len(list(data.iterdir()))
    for take in takes:
        motion = tracker.read(take).motion
        assert channels <= set(motion.columns[motion.notna().any()])


def clips_after_pose(results: Path) -> int:
    return len(tables.read_all(tables.CLIPS, results.glob("pose/*/clips.parquet")))


def measured(results: Path) -> set[str]:
    """The channels that have a value in a frame."""
    motion = tables.read_all(tables.MOTION, results.glob("ingest/*/motion.parquet"))
    return {*EXPRESSIONS, *HEAD, *GAZE} & set(motion.columns[motion.notna().any()])


def test_bare_videos_are_cut_and_the_bad_ones_are_in_the_ledger(run_example, real_data, tmp_path):
    data = tmp_path / "videos"
    data.mkdir()
    for video in ("face_noface.mov", "no_face.mp4", "single_face.mp4"):
        (data / video).symlink_to(real_data / "video" / video)
    for video in ("empty.mp4", "single_face_truncated_100k.mp4"):
        (data / video).symlink_to(real_data / "corrupt" / video)
    results = run_example("videos", data, "--until", "fetch", change="fetch: {side_px: 64}")
    ledger = tables.read_all(tables.LEDGER, results.rglob("ledger.parquet"))
    failed = ledger[ledger["status"] == "failed"].set_index("clip_id")["detail"]
    assert set(failed.index) == {"empty", "single_face_truncated_100k"}
    assert "empty" in failed["empty"]
    assert "cut off" in failed["single_face_truncated_100k"]
    clips = tables.read_all(tables.CLIPS, results.glob("fetch/*/clips.parquet"))
    assert set(clips["source_id"]) == {"face_noface", "no_face", "single_face"}
    assert (clips["n_frames"] == ((clips["end_s"] - clips["start_s"]) * 30).round()).all()
    assert all((results.parent / media).is_file() for media in clips["media"])
