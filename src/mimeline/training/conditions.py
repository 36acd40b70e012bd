"""Which regions' timelines a training sample is told."""

import torch
from torch import Tensor

from mimeline.vocabulary import ACTIONS, CONTROL_REGIONS, UNKNOWN


def drop_regions(
    timeline: Tensor, p_all: float, p_none: float, p_each: float, generator: torch.Generator
) -> Tensor:
    """The timeline (B, L, 16) with whole control regions of a sample set to -1.

    A sample loses all regions with chance p_all, none with p_none, else each with chance p_each,
    independently (Ma et al. 2025, section 3.2: 0.1, 0.1, 0.5). Returns a new tensor.
    """
    batch = len(timeline)
    lot = torch.rand(batch, 1, generator=generator)  # (B, 1)
    each = torch.rand(batch, len(CONTROL_REGIONS), generator=generator) < p_each  # (B, 5)
    dropped = torch.where(lot < p_all, True, (lot >= p_all + p_none) & each)  # (B, 5)
    region = [CONTROL_REGIONS.index(action.control_region) for action in ACTIONS.values()]
    return timeline.masked_fill(dropped[:, None, region], UNKNOWN)  # (B, L, 16)
