"""The examples of config/examples run to their report on real recordings."""

import pytest

from mimeline import tables

SMALL = """
train: {timeline: {width: 16, heads: 2, steps: 5, batch: 2}}
evaluate: {timeline: {timelines: 1, sampler_steps: 2}}
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
