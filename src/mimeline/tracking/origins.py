"""How the channels of a shard's takes were had, as the `origins` table."""

from collections.abc import Iterable
from dataclasses import replace

import pandas as pd

from mimeline import tables
from mimeline.tracking.take import Origin, Take
from mimeline.vocabulary import CHANNELS

UNTOLD = Origin("the tracking results do not hold it", measured=False)


def truthful(take: Take) -> Take:
    """The take, whose origins call no channel measured that holds no number."""
    named = [name for name, origin in take.origins.items() if origin.measured]
    holds = take.motion[named].notna().any()
    empty = {
        name: Origin(f"{take.origins[name].text}: empty throughout", measured=False)
        for name in named
        if not holds[name]
    }
    return replace(take, origins={**take.origins, **empty}) if empty else take


def origins_of(takes: Iterable[Take]) -> pd.DataFrame:
    """Table `origins`: of each channel, how the first take that measures it had it.

    quality: the least of all takes that measure it. Without takes, nothing is measured.
    """
    found: dict[str, Origin] = {}
    for take in takes:
        for channel, origin in take.origins.items():
            known = found.setdefault(channel, origin)
            if origin.measured and (not known.measured or _below(origin, known)):
                found[channel] = origin
    rows = [
        (channel, origin.measured, origin.text, origin.quality)
        for channel in CHANNELS
        for origin in (found.get(channel, UNTOLD),)
    ]
    return pd.DataFrame(rows, columns=tables.ORIGINS.schema.names)


def _below(origin: Origin, known: Origin) -> bool:
    best = 1.0 if known.quality is None else known.quality
    return origin.quality is not None and origin.quality < best
