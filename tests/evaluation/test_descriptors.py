"""Both sides and action units as a region's series."""

import numpy as np
import pandas as pd
import pytest

from mimeline.evaluation import descriptors
from mimeline.evaluation.descriptors import (
    UNITS,
    both_sides,
    measured_units,
    one_side,
    ruled_units,
)
from mimeline.vocabulary import CHANNELS, SERIES_REGIONS


@pytest.fixture
def motion() -> pd.DataFrame:
    """Two clips of 100 frames; the second raises and lowers its brows, and smiles on."""
    rng = np.random.default_rng(0)
    table = pd.DataFrame(
        {"clip_id": np.repeat(["a", "b"], 100), "frame": np.tile(np.arange(100), 2), "valid": True}
    )
    noise = rng.uniform(0, 0.1, (200, len(CHANNELS)))
    table = pd.concat([table, pd.DataFrame(noise, columns=list(CHANNELS))], axis=1)
    raised = ["browInnerUp", "browOuterUpLeft", "browOuterUpRight"]
    table.loc[120:139, raised] += 0.6
    table.loc[160:179, ["browDownLeft", "browDownRight"]] += 0.6
    table.loc[100:, ["mouthSmileLeft", "mouthSmileRight"]] += 0.6
    return table


@pytest.fixture
def plain(monkeypatch):
    """The rule without what it draws."""
    monkeypatch.setattr(descriptors, "KERNELS", (1,))
    monkeypatch.setattr(descriptors, "CHANCE", 0.0)


def test_a_channel_without_a_side_is_there_once(motion):
    assert both_sides(motion, "brow").channels == (
        "browDownLeft",
        "browInnerUp",
        "browOuterUpLeft",
        "browDownRight",
        "browOuterUpRight",
    )
    assert one_side(motion, "brow", "right").channels == (
        "browDownRight",
        "browInnerUp",
        "browOuterUpRight",
    )


def test_a_series_breaks_at_clips_and_at_frames_that_are_not_valid(motion):
    motion.loc[150, "valid"] = False
    motion.loc[170, "mouthSmileRight"] = np.nan
    assert one_side(motion, "mouth", "left").lengths.tolist() == [100, 50, 49]
    series = both_sides(motion, "mouth")
    assert series.lengths.tolist() == [100, 50, 19, 29]
    assert series.values().shape == (198, 6)


def test_what_was_not_measured_or_never_moves_is_said(motion):
    gone = motion.assign(mouthFrownLeft=np.nan)
    assert one_side(gone, "mouth", "left").reason == "not measured: mouthFrownLeft"
    assert ruled_units(gone, "mouth").reason == "not measured: mouthFrownLeft"
    assert one_side(gone, "mouth", "right").reason == ""
    still = motion.assign(eyeWideLeft=0.1, eyeWideRight=0.1)
    assert "eyeWideLeft" not in both_sides(still, "eye").channels
    nobody = motion[:0]
    for region in SERIES_REGIONS:
        assert ruled_units(nobody, region).reason == "no clip came through"
        assert both_sides(nobody, region).reason == "no clip came through"


def test_a_unit_is_active_where_its_coefficients_pass_the_threshold(motion, plain):
    series = ruled_units(motion, "brow")
    active = series.frames[list(series.channels)].to_numpy().astype(bool)  # (200, 3)
    assert series.channels == ("AU01", "AU02", "AU04")
    assert np.flatnonzero(active[:, 0]).tolist() == list(range(120, 140))
    assert np.array_equal(active[:, 0], active[:, 1])
    assert np.flatnonzero(active[:, 2]).tolist() == list(range(160, 180))


def test_a_unit_that_never_acts_is_left_out(motion):
    assert ruled_units(motion, "mouth").channels == ("AU12",)
    assert ruled_units(motion, "eye").reason.startswith("never moves: AU05, AU07")


def test_pooling_widens_and_stays_within_the_clip(motion, monkeypatch):
    monkeypatch.setattr(descriptors, "KERNELS", (7,))
    brow, mouth = ruled_units(motion, "brow").frames, ruled_units(motion, "mouth").frames
    assert np.flatnonzero(brow["AU04"]).tolist() == list(range(157, 183))
    assert np.flatnonzero(mouth["AU12"]).tolist() == list(range(100, 200))


@pytest.mark.parametrize("chance, closed", [(0.0, False), (1.0, True)])
def test_only_short_gaps_inside_a_clip_are_closed(motion, monkeypatch, plain, chance, closed):
    monkeypatch.setattr(descriptors, "CHANCE", chance)
    smile = ["mouthSmileLeft", "mouthSmileRight"]
    for gap in (slice(0, 2), slice(110, 113), slice(130, 140)):
        motion.loc[gap, smile] = 0.0
    motion.loc[98:99, smile] = 0.9
    active = ruled_units(motion, "mouth").frames["AU12"].to_numpy().astype(bool)
    assert active[110:114].all() == closed
    assert not active[130:141].any()
    assert not active[:98].any()


def test_what_is_drawn_is_drawn_again_for_the_same_seed(motion):
    first, again, other = (ruled_units(motion, "brow", seed).frames for seed in (3, 3, 4))
    pd.testing.assert_frame_equal(first, again)
    assert not first.equals(other)


def test_what_a_tracker_measured_comes_from_0_to_1(motion):
    units = motion[["clip_id", "frame"]].assign(
        **{f"{unit}_r": np.linspace(0, 5, len(motion)) for own in UNITS.values() for unit in own}
    )
    motion.loc[10, "valid"] = False
    series = measured_units(units, motion, "mouth")
    assert series.channels == UNITS["mouth"]
    assert series.lengths.tolist() == [10, 89, 100]
    assert series.frames["AU12"].iloc[-1] == pytest.approx(1)
    none = measured_units(units[:0], motion, "eye")
    assert none.reason == "not measured: AU05, AU07"
    assert not len(none.frames)
