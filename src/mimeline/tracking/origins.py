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
    found = _least(item for take in takes for item in take.origins.items())
    rows = [
        (channel, origin.measured, origin.text, origin.quality)
        for channel in CHANNELS
        for origin in (found.get(channel, UNTOLD),)
    ]
    return pd.DataFrame(rows, columns=tables.ORIGINS.schema.names)


def told(rows: pd.DataFrame) -> dict[str, Origin]:
    """Channel → its origin, of the rows of several `origins` tables, at its least quality."""
    return _least(
        (
            row.channel,
            Origin(row.origin, bool(row.measured), None if pd.isna(row.quality) else row.quality),
        )
        for row in rows.itertuples()
    )


def _least(had: Iterable[tuple[str, Origin]]) -> dict[str, Origin]:
    """Of each channel the origin that measures it, at the least quality."""
    found: dict[str, Origin] = {}
    for channel, origin in had:
        known = found.setdefault(channel, origin)
        if origin.measured and (not known.measured or _below(origin, known)):
            found[channel] = origin
    return found


def _below(origin: Origin, known: Origin) -> bool:
    best = 1.0 if known.quality is None else known.quality
    return origin.quality is not None and origin.quality < best
