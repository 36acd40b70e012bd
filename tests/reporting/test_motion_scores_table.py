import pandas as pd
import pytest

from mimeline import tables
from mimeline.reporting.motion_scores import motion_table
from mimeline.reporting.training import REGIONS, model

VARIANTS = ["request", "real"]


def metrics(*rows):
    """(variant, metric, value, low, high, n) as a `metrics` table."""
    known = {"model": "timeline", "part": "test+val", "seed": 0}
    columns = ["variant", "metric", "value", "low", "high", "n"]
    return pd.DataFrame([known | dict(zip(columns, row, strict=True)) for row in rows])


SCORED = metrics(
    ("request", "tas", 0.8, 0.7, 0.9, 12),
    ("real", "tas", 0.97, 0.95, 0.99, 12),
    ("request", "var", 0.0123, 0.0111, 0.0135, 12),
    ("real", "var", 0.0145, 0.013, 0.016, 12),
    ("request", "fid_fm", 0.5, 0.4, 0.6, 12),
    ("real", "fid_fm", 0.3, None, None, 9),
    ("request", "jerk_ratio", 0.75, 0.7, 0.8, 12),
)


def row(name):
    return next(own for own in motion_table(SCORED, VARIANTS).rows if own.name == name)


def test_a_score_stands_beside_its_floor_and_the_papers():
    made, real, paper = row("FID, motion").cells
    assert (made.value, made.interval) == ("0.500", "0.400 to 0.600")
    assert (real.value, real.interval, real.about) == ("0.300", "", "9 clips")
    assert (paper.value, paper.about) == ("0.454", "")
    assert row("variance").cells[-1].about == "real 0.0073"


def test_a_column_tells_its_number_of_clips_where_that_is_one():
    found = motion_table(SCORED, VARIANTS)
    assert found.columns[0] == ("told the timeline", "12 clips")
    assert found.columns[1] == ("real motion", "")  # 12 for one row, 9 for another
    assert row("variance").cells[0].about == ""
    assert row("variance").cells[1].about == "12 clips"


def test_what_was_not_measured_is_a_dash():
    made, real, paper = row("jerk ratio").cells
    assert (made.value, real.value, paper.value) == ("0.750", "–", "–")


def test_without_distances_of_other_real_clips_no_floor_is_told_of():
    assert motion_table(SCORED, VARIANTS).floor
    bare = SCORED[(SCORED["variant"] != "real") | (SCORED["metric"] == "var")]
    assert not motion_table(bare, VARIANTS).floor
    assert motion_table(SCORED[SCORED["metric"] == "tas"], VARIANTS) is None


@pytest.mark.parametrize(("n", "few"), [(12, True), (100, False)])
def test_a_model_of_fewer_timelines_than_the_papers_is_said_to_have_so_few(tmp_path, n, few):
    path = tmp_path / "metrics.parquet"
    tables.write(tables.METRICS, SCORED.assign(n=n)[tables.METRICS.schema.names], path)
    tables.write(tables.LOSSES, tables.empty(tables.LOSSES), tmp_path / "log.parquet", "none")
    found = model("timeline", tmp_path, path)
    assert found.few is few
    assert found.part == f"{n} clips of the test and validation parts"
    assert found.chart.variants == ["request"]
    assert found.tas["real"] == 0.97
    assert found.chart.groups[0].name == REGIONS[""]
