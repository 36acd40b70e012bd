"""Kinds of columns that several tables have, each (type, nullable, checks), and their checks."""

from collections.abc import Iterable

import pandera.pandas as pandera
import pyarrow as pa


def isin(values: Iterable[str]) -> list[pandera.Check]:
    return [pandera.Check.isin(list(values))]


def at_least(least: float) -> list[pandera.Check]:
    return [pandera.Check.ge(least)]


STRING = pa.string()
TEXT, NAME = (STRING, False, None), (STRING, True, None)
INTEGER, COUNT = (pa.int64(), False, None), (pa.int64(), False, at_least(0))
REAL = (pa.float64(), True, None)
SHARE = pandera.Check.in_range(0, 1)
INTERVAL = pandera.Check(
    lambda t: t["end_frame"] > t["start_frame"], name="half-open interval of at least a frame"
)
