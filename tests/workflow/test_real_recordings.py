"""The examples of config/examples run on real recordings, or on small takes of their format.

Three go to their report: with all channels, with short clips, with the head alone. The others stop
once what is special about their format has happened.
"""

from pathlib import Path

import pytest
import yaml

from mimeline import tables
from mimeline.config import validate
from mimeline.inspection.funnel import funnel
from mimeline.inspection.why import why
from mimeline.tracking.readers import Tracker
from mimeline.vocabulary import EXPRESSIONS, GAZE, HEAD
from mimeline.workflow import chosen

from .whole_runs import GOLDEN, small_takes

EXAMPLES = Path(__file__).parents[2] / "config" / "examples"


def test_an_example_ends_with_a_report(livelink_run):
    results = livelink_run
    assert (results / "report" / "index.html").stat().st_size > 10_000
    frames = tables.read_all(tables.FRAMES, results.glob("annotate/*/frames.parquet"))
    assert frames["clip_id"].nunique() == 13
    for action in ("HeadLeft", "HeadUp"):
        assert frames[action].isna().all()
    assert frames["BrowUp"].notna().any()
    metrics = results / "evaluate" / "annotation" / "metrics.parquet"
    assert tables.reason(metrics) == "no truth is known for these recordings"


def test_an_example_that_measures_the_head_alone_ends_with_a_report(dreamtalk_run):
    results = dreamtalk_run
    page = (results / "report" / "index.html").read_text(encoding="utf-8")
    assert "no face model was given" in page
    assert clips_after_pose(results) == 16
    assert measured(results) == set(HEAD)
    frames = tables.read_all(tables.FRAMES, results.glob("annotate/*/frames.parquet"))
    assert frames["BrowUp"].isna().all()
    assert frames["HeadUp"].notna().all()


def test_an_example_of_short_clips_ends_with_a_report(pyfeat_run):
    results = pyfeat_run
    assert (results / "report" / "index.html").stat().st_size > 10_000
    metrics = results / "evaluate" / "annotation" / "metrics.parquet"
    assert tables.reason(metrics) == "no truth is known for these recordings"
    frames = tables.read_all(tables.FRAMES, results.glob("annotate/*/frames.parquet"))
    assert frames["clip_id"].nunique() == 10
    assert frames["BrowUp"].notna().any()


def test_an_example_reads_real_recordings(openface_run):
    found = measured(openface_run)
    assert clips_after_pose(openface_run) == 1
    assert {*HEAD, *GAZE, "jawOpen", "browInnerUp"} <= found
    assert "tongueOut" not in found


def test_an_example_takes_folders_for_takes(metrical_tracker_run):
    takes = [path for path in (GOLDEN / "metrical_tracker").iterdir() if path.is_dir()]
    assert clips_after_pose(metrical_tracker_run) == len(takes)
    assert {*HEAD, *GAZE, "eyeBlinkLeft"} <= measured(metrical_tracker_run)


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


def test_bare_videos_are_cut_and_the_bad_ones_are_in_the_ledger(videos_run):
    results = videos_run
    ledger = tables.read_all(tables.LEDGER, results.rglob("ledger.parquet"))
    failed = ledger[ledger["status"] == "failed"].set_index("clip_id")["detail"]
    assert set(failed.index) == {"empty", "single_face_truncated_100k"}
    assert "empty" in failed["empty"]
    assert "cut off" in failed["single_face_truncated_100k"]
    clips = tables.read_all(tables.CLIPS, results.glob("fetch/*/clips.parquet"))
    assert set(clips["source_id"]) == {"face_noface", "no_face", "single_face"}
    assert (clips["n_frames"] == ((clips["end_s"] - clips["start_s"]) * 30).round()).all()
    assert all((results.parent / media).is_file() for media in clips["media"])


def test_the_published_sample_of_celebv_text_runs_to_its_funnel(celebvtext_run):
    found = funnel(celebvtext_run, [], [])
    assert found.problem == ""
    stages = {stage.name: stage for stage in found.funnel.stages}
    assert found.waiting == ["fetch", "ingest", "pose", "split"]
    assert stages["catalogue"].entered == 43
    assert stages["select"].entered == stages["catalogue"].kept
    clips = tables.read_all(tables.CLIPS, celebvtext_run.glob("select/*/clips.parquet"))
    assert len(clips) == stages["select"].kept == 22
    assert (clips["end_s"] - clips["start_s"]).between(5, 10).all()


def test_a_stretch_that_the_sample_lists_twice_is_told_and_kept_once(celebvtext_run):
    first, second = "oC9r-CTbToE_0_0", "oC9r-CTbToE_0_1"  # too long, both
    assert funnel(celebvtext_run, [], []).besides == [second]
    (story,) = why(celebvtext_run, [second]).stories
    assert (story.status, story.decisions[-1].rule) == ("dropped", "too_long")
    assert f"also a duplicate of {first}" in story.decisions[-1].detail
    wider = funnel(celebvtext_run, [EXAMPLES / "celebvtext.yaml"], ["select.max_s=60"])
    (change,) = wider.changes
    assert change.reasons["duplicate"] == 1
    assert first in change.gained and second not in change.gained
