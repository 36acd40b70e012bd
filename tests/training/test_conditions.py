import pytest
import torch

from mimeline.training.conditions import drop_regions
from mimeline.vocabulary import ACTIONS, CONTROL_REGIONS

ORDER = list(ACTIONS.values())


def dropped(p_all, p_none, p_each, batch=6000):
    """Which of the regions (B, 5) were dropped, and the timeline."""
    timeline = torch.ones(batch, 2, len(ACTIONS))
    timeline[:, 1] = 0
    told = drop_regions(timeline, p_all, p_none, p_each, torch.Generator().manual_seed(0))
    first = [
        next(i for i, action in enumerate(ORDER) if action.control_region == region)
        for region in CONTROL_REGIONS
    ]
    return told[:, 0, first] == -1, told


def test_the_shares_are_those_of_the_paper():
    gone, _ = dropped(0.1, 0.1, 0.5)
    count = gone.sum(dim=1)
    assert (count == 5).float().mean().item() == pytest.approx(0.1 + 0.8 / 32, abs=0.015)
    assert (count == 0).float().mean().item() == pytest.approx(0.1 + 0.8 / 32, abs=0.015)
    assert gone.float().mean().item() == pytest.approx(0.5, abs=0.02)


def test_regions_fall_independently():
    gone, _ = dropped(0.0, 0.0, 0.3)
    assert gone.float().mean(dim=0).tolist() == pytest.approx([0.3] * 5, abs=0.03)
    both = (gone[:, 0] & gone[:, 1]).float().mean().item()
    assert both == pytest.approx(0.09, abs=0.02)


def test_a_region_is_dropped_whole_and_in_every_frame():
    _, told = dropped(0.1, 0.1, 0.5, batch=200)
    for region in CONTROL_REGIONS:
        columns = [i for i, action in enumerate(ORDER) if action.control_region == region]
        gone = told[..., columns] == -1
        assert (gone.flatten(1).all(dim=1) == gone.flatten(1).any(dim=1)).all()


@pytest.mark.parametrize(
    ("chances", "share"), [((1.0, 0.0, 0.5), 1.0), ((0.0, 1.0, 1.0), 0.0), ((0.0, 0.0, 0.0), 0.0)]
)
def test_chances_of_one_and_zero_are_certain(chances, share):
    gone, _ = dropped(*chances, batch=100)
    assert gone.float().mean().item() == share


def test_the_given_timeline_stays_as_it_is():
    timeline = torch.ones(4, 3, len(ACTIONS))
    drop_regions(timeline, 1.0, 0.0, 0.5, torch.Generator().manual_seed(0))
    assert (timeline == 1).all()
