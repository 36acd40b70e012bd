from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from mimeline.errors import BadFile
from mimeline.tables import COEFFICIENTS
from mimeline.tracking.formats.action_units import ACTION_UNITS, channels, clipped
from mimeline.vocabulary import CHANNELS, EXPRESSIONS


def test_the_resource_covers_every_unit_of_the_table_and_names_channels_that_exist():
    given = {name[:4] for name in COEFFICIENTS["action_units"].schema.names if name[:2] == "AU"}
    assert {unit.unit for unit in ACTION_UNITS} == given
    assert all(set(unit.channels) <= set(EXPRESSIONS) for unit in ACTION_UNITS)
    taken = [channel for unit in ACTION_UNITS for channel in unit.channels]
    assert len(taken) == len(set(taken))  # no channel is told twice


def test_a_unit_without_a_counterpart_says_why():
    left_out = [unit for unit in ACTION_UNITS if not unit.channels]
    assert {unit.unit for unit in left_out} == {"AU23", "AU25", "AU28"}
    assert all(unit.note for unit in left_out)


def test_both_sides_move_alike_since_a_unit_tells_no_side():
    for unit in ACTION_UNITS:
        assert {CHANNELS[channel].mirror for channel in unit.channels} == set(unit.channels)


def test_a_unit_at_its_strongest_is_a_channel_at_one():
    rows = pd.DataFrame({"AU12_r": [0, 2.5, 5, np.nan], "AU01_r": [5.0, 0, 0, 0]})
    values, origins = channels(rows)
    np.testing.assert_allclose(values["mouthSmileLeft"], [0, 0.5, 1, np.nan])
    np.testing.assert_allclose(values["mouthSmileRight"], values["mouthSmileLeft"])
    assert values["browInnerUp"].iloc[0] == 1
    assert origins["mouthSmileLeft"].text == "AU12 (lip corner puller) / 5, both sides alike"
    assert origins["mouthSmileLeft"].quality is None
    assert set(values) == {"mouthSmileLeft", "mouthSmileRight", "browInnerUp"}


def test_every_expression_says_how_it_was_had_or_why_not():
    _, origins = channels(pd.DataFrame({"AU12_r": [1.0]}))
    assert set(origins) == set(EXPRESSIONS)
    assert origins["tongueOut"].text == "no action unit tells it"
    assert origins["eyeBlinkLeft"].text == "AU45 is not in the table"
    assert {name for name, origin in origins.items() if origin.measured} == {
        "mouthSmileLeft",
        "mouthSmileRight",
    }


@pytest.mark.parametrize(("value", "within", "n"), [(-0.2, 0, 1), (5.1, 5, 1), (3, 3, 0)])
def test_intensities_are_clipped_to_their_range_and_counted(value, within, n):
    rows, n_outside = clipped(pd.DataFrame({"AU12_r": [value, np.nan]}), Path())
    assert rows["AU12_r"].iloc[0] == within and n_outside == n
    assert np.isnan(rows["AU12_r"].iloc[1])


@pytest.mark.parametrize("value", [-1.5, 6.5, 20, 100])
def test_intensities_of_another_scale_are_refused(value):
    rows = pd.DataFrame({"AU01_r": [0.0, 1], "AU12_r": [np.nan, value]})
    with pytest.raises(BadFile, match=f"line 3, column AU12_r: found {value:g}"):
        clipped(rows, Path())
