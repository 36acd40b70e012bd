import re

import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.reporting.labelling import labelling, looks_needed


@pytest.fixture
def spent(run):
    """What the labelling's metrics tell; change: of the rows."""

    def spent(change=lambda rows: rows):
        path = run()["labelling"]
        tables.write(tables.METRICS, change(tables.read(tables.METRICS, path)), path)
        return labelling(path)

    return spent


def ends(path: str) -> tuple[tuple[float, float], tuple[float, float]]:
    points = [tuple(map(float, point.split())) for point in re.findall(r"[ML]([^MLZ]+)", path)]
    return points[0], points[-1]


@pytest.mark.parametrize(
    ("values", "looks"),
    [([0.9, 0.9, 0.9], 0), ([0.2, 0.895, 0.9], 2), ([0.2, 0.9, 0.5, 0.9], 5), ([0, 0, 0.9], 4)],
)
def test_looks_are_enough_from_where_a_curve_stays_close_to_its_end(values, looks):
    assert looks_needed(np.array([0, 2, 4, 5])[: len(values)], np.array(values), 0.01) == looks


def test_the_sentence_tells_how_many_looks_do_what_all_of_them_do(spent):
    told = spent().sentence
    assert told.startswith("4 looks, chosen where they help most, come within 0.01 of what all 10")
    assert "chosen at random, it takes 10." in told
    assert told.endswith("Where names are proposed before, it takes 1.")


def test_proposals_that_need_no_look_are_said(spent):
    def right(rows: pd.DataFrame) -> pd.DataFrame:
        return rows.assign(value=rows["value"].mask(rows["variant"] == "active", 0.9))

    assert spent(right).sentence.endswith("Where names are proposed before, it takes none.")


def test_without_the_curves_that_start_from_nothing_there_is_no_sentence(spent):
    assert spent(lambda rows: rows[~rows["variant"].str.endswith("_unproposed")]).sentence == ""


def test_curves_start_and_end_where_their_scores_are(spent):
    found = spent()
    assert [plot.name for plot in found.plots] == ["mean", "brow", "eye", "mouth"]
    large = found.plots[0]
    (left, bottom), (right, top) = ends(dict(large.lines)["active_unproposed"])
    assert (left, right) == (large.left, large.right)
    assert large.ceiling < top < large.proposed[1] < bottom <= large.floor
    assert large.proposed[0] == large.left
    assert all(plot.width < large.width for plot in found.plots[1:])
    assert found.facts[0] == ("mean", [0.85, 0.9, 0.93])


def test_the_band_is_about_the_random_looks_and_closed(spent):
    assert spent().plots[0].band.endswith("Z")
    assert spent(lambda rows: rows.assign(low=np.nan, high=np.nan)).plots[0].band == ""


def test_regions_share_one_scale(spent):
    scales = [plot.y_ticks for plot in spent().plots[1:]]
    assert scales[0] == scales[1] == scales[2]


def test_without_a_truth_there_is_nothing_to_tell(spent, empty_run):
    assert spent(lambda rows: rows[:0]) is None
    assert labelling(empty_run["labelling"]) is None


def test_a_single_region_is_not_told_twice(spent):
    found = spent(lambda rows: rows[rows["metric"].isin(["f1", "f1_eye"])])
    assert [plot.name for plot in found.plots] == ["eye"]
