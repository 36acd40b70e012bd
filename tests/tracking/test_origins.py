from dataclasses import replace
from fractions import Fraction

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.tracking.origins import UNTOLD, origins_of, told, truthful
from mimeline.tracking.take import Origin, Take
from mimeline.vocabulary import CHANNELS

POOR, FAIR = Origin("mapped", quality=0.4), Origin("fitted", quality=0.7)
READ, EMPTY = Origin("column JawOpen"), Origin("no column", measured=False)


def rows(**origins: Origin) -> pd.DataFrame:
    return pd.DataFrame(
        [(name, o.measured, o.text, o.quality) for name, o in origins.items()],
        columns=tables.ORIGINS.schema.names,
    )


def test_of_several_tables_the_least_measured_quality_is_told():
    among = pd.concat([rows(jawOpen=FAIR), rows(jawOpen=EMPTY), rows(jawOpen=POOR)])
    assert told(among) == {"jawOpen": POOR}
    assert told(pd.concat([rows(jawOpen=READ), rows(jawOpen=FAIR)])) == {"jawOpen": FAIR}
    assert told(pd.concat([rows(jawOpen=EMPTY), rows(jawOpen=READ)])) == {"jawOpen": READ}
    assert told(rows(jawOpen=EMPTY)) == {"jawOpen": EMPTY}


def test_origins_survive_their_table(tmp_path):
    origins = {name: POOR if name == "jawOpen" else EMPTY for name in CHANNELS}
    tables.write(tables.ORIGINS, rows(**origins), tmp_path / "origins.parquet")
    assert told(tables.read(tables.ORIGINS, tmp_path / "origins.parquet")) == origins


def test_without_takes_nothing_is_measured():
    assert set(told(origins_of([])).values()) == {UNTOLD} and len(origins_of([])) == len(CHANNELS)


def test_a_channel_that_holds_no_number_is_not_called_measured():
    motion = pd.DataFrame({"jawOpen": [0.0, 0.5], "browInnerUp": [0.1, np.nan]})
    take = Take(motion, Fraction(25), origins={"jawOpen": READ, "browInnerUp": FAIR})
    assert truthful(take) is take
    silent = replace(take, motion=motion.assign(jawOpen=np.nan))
    assert truthful(silent).origins == {
        "jawOpen": Origin("column JawOpen: empty throughout", measured=False),
        "browInnerUp": FAIR,
    }
