"""The examples of config/examples run to their report on real recordings."""

import pytest

from mimeline import tables

SMALL = """
train: {timeline: {width: 16, heads: 2, steps: 5, batch: 2}}
evaluate: {timeline: {timelines: 1, sampler_steps: 2}}
report: {clips: 1, exemplars: 1}
"""


@pytest.mark.parametrize(
    ("name", "folder", "clips", "absent"),
    [
        ("livelink", "arkit_livelink", 13, ("HeadLeft", "HeadUp")),
        ("pyfeat", "pyfeat", 10, ()),
    ],
)
def test_an_example_ends_with_a_report(checkout, real_data, tmp_path, name, folder, clips, absent):
    small = tmp_path / "small.yaml"
    small.write_text(SMALL)
    config = (f"config/examples/{name}.yaml", str(small))
    done = checkout.run("--config", f"data_dir={real_data / folder}", config=config)
    assert done.returncode == 0, done.stdout + done.stderr
    results = checkout.root / f"results-{name}"
    assert (results / "report" / "index.html").stat().st_size > 10_000
    frames = tables.read_all(tables.FRAMES, results.glob("annotate/*/frames.parquet"))
    assert frames["clip_id"].nunique() == clips
    for action in absent:
        assert frames[action].isna().all()
    assert frames["BrowUp"].notna().any()
    metrics = results / "evaluate" / "annotation" / "metrics.parquet"
    assert tables.reason(metrics) == "no truth is known for these recordings"


def test_bare_videos_are_cut_and_the_bad_ones_are_in_the_ledger(checkout, real_data, tmp_path):
    data = tmp_path / "videos"
    data.mkdir()
    for video in ("face_noface.mov", "no_face.mp4", "single_face.mp4"):
        (data / video).symlink_to(real_data / "video" / video)
    for video in ("empty.mp4", "single_face_truncated_100k.mp4"):
        (data / video).symlink_to(real_data / "corrupt" / video)
    config, small = ("config/examples/videos.yaml",), ("--config", "fetch={side_px: 64}")
    done = checkout.run(*small, f"data_dir={data}", "--until", "fetch", config=config)
    assert done.returncode == 0, done.stdout + done.stderr
    results = checkout.root / "results-videos"
    ledger = tables.read_all(tables.LEDGER, results.rglob("ledger.parquet"))
    failed = ledger[ledger["status"] == "failed"].set_index("clip_id")["detail"]
    assert set(failed.index) == {"empty", "single_face_truncated_100k"}
    assert "empty" in failed["empty"]
    assert "cut off" in failed["single_face_truncated_100k"]
    clips = tables.read_all(tables.CLIPS, results.glob("fetch/*/clips.parquet"))
    assert set(clips["source_id"]) == {"face_noface", "no_face", "single_face"}
    assert (clips["n_frames"] == ((clips["end_s"] - clips["start_s"]) * 30).round()).all()
    assert all((checkout.root / media).is_file() for media in clips["media"])
